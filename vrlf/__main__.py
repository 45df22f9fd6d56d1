"""``python -m vrlf`` is ``vrlf``."""

from vrlf.app.main import main

if __name__ == "__main__":
    main()
