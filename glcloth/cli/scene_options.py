"""Options that are fields of a scene. Made from these by `python -m glcloth.cli.generate`: do not edit."""

# fmt: off
# ruff: noqa: E501
from dataclasses import dataclass
from typing import Annotated

from cyclopts import Parameter

from .common import whole


@Parameter(name="*")
@dataclass
class SceneOptions:
    """What to render; an option that is not given keeps the scene's value."""

    fabric: Annotated[list[str] | None, Parameter(name="--fabric", negative="", help="Built-in fabric, a .toml file or a draft (.wif); PART=FABRIC for a material, group or object alone (* and ? match any); repeatable.")] = None
    threads: Annotated[bool | None, Parameter(help="Threads where one comes near, of a fabric with a weave.")] = None
    uv_scale: Annotated[float | None, Parameter(help="Length of a UV unit of the mesh, for the size of threads; 0: measured (0 to 1000 m).")] = None
    mesh: Annotated[list[str] | None, Parameter(name="--mesh", negative="", help="Built-in mesh or a file (.obj .ply .glb .gltf .stl .off); repeatable.")] = None
    subdivide: Annotated[int | None, Parameter(converter=whole, help="Times that each triangle of the cloth is cut into four on a smooth surface (Loop), for coarse meshes (0 to 4).")] = None
    print: Annotated[list[str] | None, Parameter(name="--print", negative="", help="A picture that the yarns' colours are multiplied by, over the UVs: a table in files; PART=FILE for a part alone; repeatable.")] = None
    opacity: Annotated[list[str] | None, Parameter(name="--opacity", negative="", help="A picture that says where cloth is, over the UVs: black is open; a table in files; PART=FILE for a part alone; repeatable.")] = None
    fabric_mask: Annotated[list[str] | None, Parameter(name="--fabric-mask", negative="", help="A picture whose colours say which fabric a place has, over the UVs, with --fabric '#rrggbb=FABRIC' for each colour; a table in files; PART=FILE for a part alone; repeatable.")] = None
    objects: Annotated[list[str] | None, Parameter(name="--object", negative="", help="Mesh that stands by the cloth, in its own colours; behind it @x,y,z,scale,turn (metres, factor, degrees about +Y), as many as are needed; repeatable.")] = None
    units: Annotated[str | None, Parameter(help="Of the lengths in mesh files; auto: metres, but for cloth that would be 20 m or more (auto, m, dm, cm, mm or in).")] = None
    ground: Annotated[str | None, Parameter(help="Height of a ground; alone or auto: just under the lowest point; catcher: there, but only its shadow is seen; or off (m).")] = None
    ground_color: Annotated[str | None, Parameter(help="What the ground reflects, R,G,B (0 to 1 linear Rec. 709).")] = None
    env: Annotated[str | None, Parameter(help="Built-in environment or a .hdr or .exr file.")] = None
    layer: Annotated[str | None, Parameter(help="Layer of an OpenEXR environment with several; none: the picture proper.")] = None
    env_layout: Annotated[str | None, Parameter(help="How the environment's picture covers the sphere: cube maps are crosses or strips, balls angular or mirrors (auto, equirect, cross, strip, angular or mirror).")] = None
    env_rotate: Annotated[float | None, Parameter(help="Turn the environment about +Y; in the window, drag with the right button (degrees).")] = None
    lobes: Annotated[str | None, Parameter(help="Spherical Gaussians fitted to the environment, 1 to 64, or auto.")] = None
    lights: Annotated[str | None, Parameter(help="File of lights (.json, .toml) instead of a fit; `glcloth env` writes one.")] = None
    method: Annotated[str | None, Parameter(help="How light on the cloth is summed; path: by samples of all its ways, for finished pictures and as the judge; the curtain is traced (trace, path) (direct, paper, reference, path or trace).")] = None
    quality: Annotated[str | None, Parameter(help="Nodes per light: draft is fastest, high is closest to the reference (draft, normal or high; method direct).")] = None
    adaptive: Annotated[bool | None, Parameter(help="Shade one pixel in four where neighbours are alike; small pictures in the window always do (method direct).")] = None
    shade: Annotated[str | None, Parameter(help="By which programs pixels are shaded, with the same picture: fragments, as in the papers, compute, or auto: what was measured as faster on this device (auto, fragment or compute).")] = None
    light: Annotated[str | None, Parameter(help="The fitted lights, or the map itself (reference, path) (sg or map; method reference).")] = None
    shadows: Annotated[str | None, Parameter(help="What the cloth hides from itself: nothing, the suns, or all the light (off, sun or full).")] = None
    bounce: Annotated[bool | None, Parameter(help="Light from fold to fold; reference: once (with shadows full).")] = None
    segments: Annotated[int | None, Parameter(converter=whole, help="Theta segments per Gaussian; the paper has 6 (2 to 64; method paper).")] = None
    cube: Annotated[int | None, Parameter(converter=whole, help="Edge of the cube map whose directions are summed (4 to 128 texels; method reference).")] = None
    grid: Annotated[int | None, Parameter(converter=whole, help="Directions per axis of the tables; a change makes new ones (8 to 96; method paper).")] = None
    contribution: Annotated[float | None, Parameter(help="Share of the singular values that tables keep; a change makes new ones (0.5 to 0.9999; method paper).")] = None
    spp: Annotated[int | None, Parameter(converter=whole, help="Samples per pixel of a whole picture; path: 1 stands for 64, or with noise for as many as it takes (1 to 1.04858e+06).")] = None
    noise: Annotated[float | None, Parameter(help="Stop where the mean standard error of the pixels that show surfaces is so small a share of their mean light, spp at the latest; 0: never before (0 to 100 %; method path).")] = None
    denoise: Annotated[bool | None, Parameter(help="Take what noise is left away, by Open Image Denoise (pip install 'glcloth[denoise]') (method path).")] = None
    size: Annotated[str | None, Parameter(help="WIDTHxHEIGHT (pixels).")] = None
    exposure: Annotated[float | None, Parameter(help="Brightness on screen and in PNG files; EXR files keep the light itself (-20 to 20 stops).")] = None
    view_transform: Annotated[str | None, Parameter(help="From light to the screen and PNG files (standard, filmic, neutral or agx).")] = None
    ocio: Annotated[str | None, Parameter(help="OpenColorIO config (.ocio .ocioz, or built in: ocio://default) whose views take the place of the view transform; none: $OCIO where that is set and no view transform is said; or off.")] = None
    display: Annotated[str | None, Parameter(help="Display of the config; none: its default.")] = None
    ocio_view: Annotated[str | None, Parameter(help="View of that display; none: its default.")] = None
    background: Annotated[bool | None, Parameter(help="Show the environment behind the cloth.")] = None
    accelerator: Annotated[str | None, Parameter(help="What rays are traced through; all give the same picture; median: large nodes cut as in paper B (kdtree, kdtree_median, lbvh or brute; curtain).")] = None
    depth: Annotated[int | None, Parameter(converter=whole, help="Generations of rays: through the cloth and mirrored by it (1 to 8; curtain).")] = None
    room: Annotated[str | None, Parameter(help="OBJ file of the room; none: built in (curtain).")] = None
    gi: Annotated[str | None, Parameter(help="Light around the room: radiosity, of the sky, the curtain and all bounces; photons: the same by photon mapping, for stills; off: even light (off, radiosity or photons; curtain).")] = None
    photons: Annotated[int | None, Parameter(converter=whole, help="Photons that begin for each sample of the pixels (gi photons) (1000 to 2e+06; curtain).")] = None
    photon_neighbours: Annotated[int | None, Parameter(converter=whole, help="Nearest photons of an estimate in the first sample; later ones take fewer (gi photons) (8 to 2000; curtain).")] = None
    spread: Annotated[bool | None, Parameter(help="Blur what is seen through the yarns; needs many samples per pixel (curtain).")] = None
    sun: Annotated[str | None, Parameter(help="What shines in: the lamp, or the brightest sun of the environment, a disc far away; where no sun of the map does, the sky alone (lamp or map; curtain).")] = None
    view: Annotated[str | None, Parameter(help="Framed by the size of the cloth: front, three-quarter, side, back, close; or a camera of the mesh's .glb or .gltf file by its name, or file for its only one.")] = None
    eye: Annotated[str | None, Parameter(help="Where the camera is, X,Y,Z (m).")] = None
    target: Annotated[str | None, Parameter(help="What it looks at, X,Y,Z (m).")] = None
    up: Annotated[str | None, Parameter(help="Direction that is up in the picture, X,Y,Z; none: +Y, or as the view has it.")] = None
    fov_deg: Annotated[float | None, Parameter(name="--fov", help="Angle of view, from top to bottom (1 to 170 degrees).")] = None
    ortho: Annotated[float | None, Parameter(help="Parallel rays instead of an angle of view: height of the picture (0.001 to 1e+06 m).")] = None
    aperture: Annotated[float | None, Parameter(help="Diameter of the lens, which blurs what is not at the focus; by the samples per pixel (0 to 10 m).")] = None
    focus: Annotated[float | None, Parameter(help="Distance along the view of what is sharp; none: that of the target (0.001 to 1e+06 m).")] = None
    width: Annotated[float | None, Parameter(help="Length of the rail (from 0.001 m; curtain).")] = None
    drop: Annotated[float | None, Parameter(help="Length of the cloth (from 0.001 m; curtain).")] = None
    fullness: Annotated[float | None, Parameter(help="Width of the cloth over that of the rail (1 to 4; curtain).")] = None
    heading: Annotated[str | None, Parameter(help="Tape holds the whole upper edge in deep folds, pencil in narrow ones; rings hold the front of each fold; with eyelet even folds, with rod narrow gathers stand about the rod, and a little above it (tape, rings, pencil, eyelet or rod; curtain).")] = None
    color: Annotated[str | None, Parameter(help="Colour of the cloth instead of its fabric's own, which colours what shines through as well: R,G,B, #rrggbb, or a name such as crimson; none: the fabric's (0 to 1 linear Rec. 709; curtain).")] = None
    open: Annotated[float | None, Parameter(help="The curtain is a pair, drawn so far apart in the middle; 0: one piece (from 0 m; curtain).")] = None
    behind: Annotated[str | None, Parameter(help="Fabric of a second curtain between this one and the window, such as blackout behind a sheer; none: there is none (curtain).")] = None
    behind_open: Annotated[float | None, Parameter(help="The second curtain is a pair, drawn so far apart in the middle; 0: one piece (from 0 m; curtain).")] = None
    wind: Annotated[float | None, Parameter(help="Wind into the room, perpendicular to the window; animate: along the built-in cloth (-20 to 20 m/s; curtain).")] = None
    print_repeat: Annotated[float | None, Parameter(help="Print: How much of the cloth one repeat covers, along u; in metres it keeps its proportions along v (0.001 to 1e+06).")] = None
    print_unit: Annotated[str | None, Parameter(help="Print: Of the repeat: UV units, where it is as high as wide, or metres (uv or m).")] = None
    print_space: Annotated[str | None, Parameter(help="Print: Of the codes in a PNG or JPEG: sRGB, or linear; OpenEXR and Radiance are always linear (srgb or linear).")] = None
    opacity_repeat: Annotated[float | None, Parameter(help="Opacity: How much of the cloth one repeat covers, along u; in metres it keeps its proportions along v (0.001 to 1e+06).")] = None
    opacity_unit: Annotated[str | None, Parameter(help="Opacity: Of the repeat: UV units, where it is as high as wide, or metres (uv or m).")] = None
    fabric_mask_repeat: Annotated[float | None, Parameter(help="Fabric mask: How much of the cloth one repeat covers, along u; in metres it keeps its proportions along v (0.001 to 1e+06).")] = None
    fabric_mask_unit: Annotated[str | None, Parameter(help="Fabric mask: Of the repeat: UV units, where it is as high as wide, or metres (uv or m).")] = None
