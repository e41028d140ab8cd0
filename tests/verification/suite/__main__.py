"""The verification suite: python3 tests/verification/suite PROGRAM [OPTION...] [CASE...]

Runs the cases of tests/verification/cases with the program and compares the results with their references.
The full form of all cases writes docs/verification.md and its plots. The exit code is 1 if a number is off.
"""

import argparse
import os
import sys
import time

from cases import Case
from program import Program, ProgramError
from report import line_of, stored, store, write_page

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
CASES = os.path.join(ROOT, "tests", "verification", "cases")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--short", action="store_true", help="only the runs of the automatic tests")
    parser.add_argument("--work", default=os.path.join(ROOT, "build", "verification"),
                        help="folder of the results (default: build/verification)")
    parser.add_argument("--page", action="store_true",
                        help="make no runs; write the page from the results that are there")
    parser.add_argument("--meshes", action="store_true",
                        help="make no runs; write the meshes that lie beside the scenes")
    parser.add_argument("cases", nargs="*", metavar="CASE", help="names of folders; default: all")
    options = parser.parse_intermixed_args()
    everything = sorted(os.listdir(CASES))
    unknown = set(options.cases) - set(everything)
    if unknown:
        parser.error(f"no case {', '.join(sorted(unknown))}; there are {', '.join(everything)}")
    if options.meshes:
        for name in options.cases or everything:
            case = Case(os.path.join(CASES, name))
            case.write_shipped_mesh(case.folder)
        return 0
    program = Program(options.program)
    failures = 0
    for name in [] if options.page else options.cases or everything:
        case = Case(os.path.join(CASES, name))
        print(f"{name}: {case.table['title']}", flush=True)
        start = time.monotonic()
        try:
            values, orders = case.execute(program, os.path.join(options.work, name), options.short,
                                          lambda value: print("  " + line_of(value), flush=True))
        except ProgramError as error:
            print(error)
            failures += 1
            continue
        for order in orders:
            print("  " + line_of(order))
        failures += sum(not result.holds for result in values + orders)
        if not any(value.is_asserted for value in values) and not orders:
            print("  nothing is asserted: no run of this form has a tolerance")
            failures += 1
        print(f"  {time.monotonic() - start:.1f} s, {'short' if options.short else 'full'} form",
              flush=True)
        if not options.short:
            store(options.work, name, values, orders)
    if not options.short:
        missing = [name for name in everything if stored(options.work, name) is None]
        if missing:
            print(f"docs/verification.md is written when these cases have results, too: {', '.join(missing)}")
        else:
            write_page(ROOT, [Case(os.path.join(CASES, name)) for name in everything], options.work)
    if failures:
        print(f"{failures} results are off")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
