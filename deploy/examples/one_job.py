#!/usr/bin/env python3
"""Submits a job to an open shop, follows it, and prints what became of it.

    deploy/examples/one_job.py job.textproto --arm --folder shop

Ctrl-C leaves the job as it is. Ends with the exit code of intaglio (docs/cli.md).
"""

import argparse
import sys

import intaglio


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("job", help="job file")
    parser.add_argument("--arm", action="store_true", help="you are at the machine")
    parser.add_argument("--folder", default="intaglio-shop", help="of the shop, for its history")
    parser.add_argument("--intaglio", default="intaglio", help="the program")
    parser.add_argument("--domain", type=int)
    parser.add_argument("--tag")
    options = parser.parse_args()

    shop = intaglio.Intaglio(options.intaglio, domain=options.domain, tag=options.tag)
    number = None
    try:
        number = shop.submit(options.job, arm=options.arm).job
        for event in shop.watch(number):
            share = f"{100 * event.done // event.total:3} %" if event.total else "     "
            print(f"{event.state:<16} {event.stage:<10} {share}  {event.message}")
        exit_code = 0
    except intaglio.IntaglioError as error:
        print(error.message, file=sys.stderr)
        exit_code = error.exit_code
    if number is not None:
        for row in shop.history(folder=options.folder, job=number):
            print(f"job {row.job}: {row.state}, {row.verdict or 'no verdict yet'}, "
                  f"{row.made} of {row.planned} points in {row.duration_s:.0f} s")
    return exit_code


if __name__ == "__main__":
    sys.exit(main())
