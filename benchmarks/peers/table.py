"""Runs of several programs, repeated in rounds, as a table in Markdown."""

# The residual of a step may be 1e-8 of its forces, and 20 steps add up.
AGREEMENT = 1e-7


def merged(rounds):
    """One result of those of all rounds: the least time of each step, and the least memory."""
    result = dict(rounds[0])
    result["seconds"] = [min(times) for times in zip(*(each["seconds"] for each in rounds))]
    result["bytes"] = min(each["bytes"] for each in rounds)
    return result


def milliseconds(result):
    return 1e3 * sum(result["seconds"]) / len(result["seconds"])


def difference(result, ours):
    return abs(result["tip"] / ours["tip"] - 1)


def three_digits(value):
    return f"{value:.{0 if value >= 100 else 1 if value >= 10 else 2}f}"


def table(results, tetrahedra):
    """The lines of the table. `results` has a list of results for each size, the first of which is ours;
    `tetrahedra` has the number of tetrahedra for each size."""
    lines = [
        "| body | program | ms per step | times ours | Newton | CG | bytes per tetrahedron | difference of the tip |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for size, rows in results.items():
        ours = rows[0]
        for row in rows:
            steps = len(row["seconds"])
            cells = [
                size,
                f"{row['program']}, {row['solver']}",
                three_digits(milliseconds(row)),
                "1" if row is ours else f"{milliseconds(row) / milliseconds(ours):.1f}",
                f"{row['newton'] / steps:.2f}",
                three_digits(row["iterations"] / steps),
                f"{row['bytes'] / tetrahedra[size]:.0f}",
                f"tip: {ours['tip']:.9f} m" if row is ours else f"{difference(row, ours):.0e}",
            ]
            lines.append("| " + " | ".join(cells) + " |")
    return lines


def disagreements(results):
    """A sentence for each result whose tip is not that of ours."""
    return [
        f"{row['program']}, {row['solver']}: the tip of {size} is at {row['tip']:.10f} m, ours at "
        f"{rows[0]['tip']:.10f} m; they may differ by {AGREEMENT:g} of it."
        for size, rows in results.items()
        for row in rows[1:]
        if not difference(row, rows[0]) <= AGREEMENT
    ]
