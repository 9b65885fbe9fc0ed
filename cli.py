"""Run phonanim from a clone, without installing it: `python cli.py animate a.TextGrid`."""

from phonanim.__main__ import main

if __name__ == "__main__":
    main()
