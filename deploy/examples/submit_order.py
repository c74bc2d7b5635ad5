#!/usr/bin/env python3
"""Submits an order by the web console, once, however often it runs: submit_order.py ADDRESS ID
JOB_FILE [FILE...]; a name and a password are read from INTAGLIO_USER and INTAGLIO_PASSWORD."""

import os
import pathlib
import sys

# The source tree's; elsewhere the package python3-intaglio has it.
sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "python"))
import intaglio_console  # noqa: E402


def main():
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    shop = intaglio_console.Console(sys.argv[1])
    try:
        if os.environ.get("INTAGLIO_USER"):
            shop.log_in(os.environ["INTAGLIO_USER"], os.environ.get("INTAGLIO_PASSWORD", ""))
        print("job", shop.submit(sys.argv[2], sys.argv[3], sys.argv[4:])["job"])
    except intaglio_console.Refused as refused:
        sys.exit(f"submit_order.py: {refused}")


if __name__ == "__main__":
    main()
