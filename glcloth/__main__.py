"""`python -m glcloth` and `glcloth`: the first lines that run, so that Ctrl-C is heard from the first moment on."""

import os
import signal
import sys


def _leave(*_) -> None:
    """While modules load nothing needs tidying, and some of them swallow KeyboardInterrupt: leave at once."""
    os.write(2, b"glcloth: stopped\n")
    os._exit(130)


def main() -> None:
    """Run the command line."""
    signal.signal(signal.SIGINT, _leave)
    from .cli import main as run

    try:
        run()
    finally:
        # All is said and done. Python itself would end without a word if Ctrl-C came while it tidies up.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        # Where Ctrl-C met code that is made from text, such as a named tuple's, `python -m` would end by the signal in place
        # of our exit code; it forgets that with the next such code.
        exec("")


if __name__ == "__main__":
    sys.exit(main())
