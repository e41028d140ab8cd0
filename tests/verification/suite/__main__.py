"""The verification suite: python3 tests/verification/suite PROGRAM [OPTION...] [CASE...]

Runs the cases of tests/verification/cases with the program and compares the results with their references.
The full form writes docs/verification.md and its plots. The exit code is 1 if a number is off.
"""

import argparse
import functools
import os
import sys
import time

from cases import Case
from program import EarlierRuns, Program, ProgramError
from report import line_of, write_page

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", ".."))
CASES = os.path.join(ROOT, "tests", "verification", "cases")


def execute(case, program, options, report=print):
    """Values and orders of a case, and the number of those that are off."""
    report(f"{case.name}: {case.table['title']}")
    start = time.monotonic()
    values, orders = case.execute(program, os.path.join(options.work, case.name), options.short,
                                  lambda value: report("  " + line_of(value)))
    for order in orders:
        report("  " + line_of(order))
    report(f"  {time.monotonic() - start:.1f} s")
    results = values + orders
    failures = sum(not result.holds for result in results)
    if not any(result.is_asserted for result in results):
        report("  nothing is asserted: no run of this form has a tolerance")
        failures += 1
    return (values, orders), failures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("--short", action="store_true", help="only the runs of the automatic tests")
    parser.add_argument("--work", default=os.path.join(ROOT, "build", "verification"),
                        help="folder of the results (default: build/verification)")
    parser.add_argument("--page", action="store_true",
                        help="make no runs, but write the page from the results that are there")
    parser.add_argument("--meshes", action="store_true",
                        help="make no runs, but write the meshes that lie beside the scenes")
    parser.add_argument("cases", nargs="*", metavar="CASE",
                        help="folders of tests/verification/cases; default: all. The page takes the "
                        "results of the others from earlier runs")
    options = parser.parse_intermixed_args()
    everything = {name: Case(os.path.join(CASES, name)) for name in sorted(os.listdir(CASES))}
    chosen = options.cases or list(everything)
    for name in chosen:
        if name not in everything:
            parser.error(f"no case {name}; there are {', '.join(everything)}")
    if options.meshes:
        for name in chosen:
            everything[name].write_shipped_mesh(everything[name].folder)
        return 0
    program = Program(options.program)
    results, failures = {}, 0
    for name, case in everything.items():
        run_now = name in chosen and not options.page
        if options.short and not run_now:
            continue
        try:
            if run_now or options.page:
                results[case], off = execute(case, program if run_now else EarlierRuns(), options,
                                             functools.partial(print, flush=True))
                failures += off
            else:
                results[case], _ = execute(case, EarlierRuns(), options, lambda line: None)
        except ProgramError as error:
            if run_now or options.page:
                print(error)
            failures += run_now
    if not options.short and len(results) == len(everything):
        write_page(ROOT, results)
        print("docs/verification.md is written")
    elif not options.short:
        print("docs/verification.md is written when all cases have results")
    if failures:
        print(f"{failures} results are off")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
