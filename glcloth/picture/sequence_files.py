"""The files of a sequence: poses and frames with numbers, or a video."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ..color import Transform, view
from ..errors import InputError
from ..files import atomic_write, check_writable
from ..image import check_output, write_image
from .layers import Layers

VIDEO = (".mp4",)
NUMBER = re.compile(r"%0?(\d{0,2})d")


def pose_files(pattern: str, count: int, start: int = 0) -> dict[int, Path]:
    """The files of the poses `start` to `count` - 1 of a pattern such as poses/%04d.ply, and of those before them as far
    back as there is no gap. Raises InputError for one that is missing."""
    if len(NUMBER.findall(pattern)) != 1:
        raise InputError(f"--mesh {pattern}: expected one number, such as poses/%04d.ply")
    files = {number: frame_name(pattern, number) for number in range(count)}
    for number in range(start, count):
        if not files[number].is_file():
            there = [n for n, file in files.items() if file.is_file()]
            if not there:
                hint = f"of {pattern} there is none; check the path"
            elif there[0] > number:
                hint = f"its poses begin at {there[0]}: choose --start {there[0]}"
            else:
                hint = f"there are {number - there[0]} from {there[0]} on: choose --frames {number}"
            raise InputError(f"{files[number]}: no such file, pose of frame {number} of {count}; {hint}")
    first = start
    while first and files[first - 1].is_file():
        first -= 1
    return {number: files[number] for number in range(first, count)}


def frame_name(pattern: str, number: int) -> Path:
    """The file of one frame of a pattern such as frames/%04d.png."""
    return Path(NUMBER.sub(lambda match: f"{number:0{match[1] or 1}d}", pattern))


def check_sequence(output: Path, size: tuple[int, int]) -> bool:
    """Return True if `output` is a video, False if it is a pattern of frames; make the folder of the frames.

    Raises InputError for a name that is neither, a folder that cannot be written, an odd size or a missing PyAV.
    """
    text = str(output)
    if output.suffix.lower() in VIDEO:
        check_writable(output)
        if size[0] % 2 or size[1] % 2:
            raise InputError(f"{output}: size {size[0]}x{size[1]}: video needs even sides; choose an even --size")
        try:
            import av  # noqa: F401
        except ImportError:
            raise InputError(
                f"{output}: video needs PyAV: pip install 'glcloth[video]'; or write frames/%04d.png"
            ) from None
        return True
    if len(NUMBER.findall(output.name)) != 1:
        raise InputError(f"{text}: expected a video (.mp4) or frames with their number, such as frames/%04d.png")
    try:
        output.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{output.parent}: cannot be made ({error.strerror}); choose another folder") from None
    check_output(frame_name(text, 0))
    return False


def write_frames(
    pictures: Iterable[Any],
    pattern: str,
    start: int,
    settings: dict | Callable[[int], dict],
    exposure: float,
    transform: Transform,
):
    """Write numbered pictures, each whole or not at all, with their settings (or a function of the frame's number);
    yields after each, so that the caller can show progress."""
    for number, picture in enumerate(pictures, start):
        path = frame_name(pattern, number)
        header = settings(number) if callable(settings) else settings
        write_picture(path, picture, {**header, "frame": number}, exposure, transform)
        yield path


def write_picture(path: Path, picture: Any, settings: dict, exposure: float, transform: Transform) -> None:
    """Write a picture, or the picture of Layers with these."""
    layers = picture if isinstance(picture, Layers) else None
    shown = picture if layers is None else layers["beauty"]
    write_image(path, shown, settings, exposure=exposure, view_transform=transform, layers=layers)


def write_video(pictures: Iterable[np.ndarray], path: Path, rate: int, exposure: float, transform: Transform):
    """Write an H.264 video, whole or not at all; yields after each frame."""
    import av

    with atomic_write(path) as temporary, av.open(str(temporary), "w") as container:
        stream = None
        for picture in pictures:
            code = np.round(255 * view(picture[..., :3], transform, exposure)).astype(np.uint8)
            if stream is None:
                stream = container.add_stream("libx264", rate=rate, options={"crf": "16", "preset": "medium"})
                stream.height, stream.width = code.shape[:2]
                stream.pix_fmt = "yuv420p"
            container.mux(stream.encode(av.VideoFrame.from_ndarray(code, "rgb24")))
            yield path
        if stream is not None:
            container.mux(stream.encode())
