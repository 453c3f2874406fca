"""The methods that the paper cites beside this library's, on the paper's surfaces and a Kerr horizon.

    python -m reproduction.baselines [--vertices N] [--degree L] [--steps T]

Printed, in Markdown, are the residual (the largest length error over the mean edge length), the distance (the
largest of a vertex from its place on the true surface over the diameter, after the best rigid motion or
reflection), inverted and partially inverted vertices, concave edges, seconds and how the method ended.
"""

import argparse

from reproduction.baselines.subjects import paper_subjects
from reproduction.baselines.table import COLUMNS, compare, run_table


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--vertices", type=int, default=800, help="of each mesh (default 800)")
    parser.add_argument("--degree", type=int, default=16, help="of the harmonics (default 16)")
    parser.add_argument("--steps", type=int, default=4, help="of the embedding flow (default 4)")
    asked = parser.parse_args()
    print("| " + " | ".join(COLUMNS) + " |")
    print("|" + "---|" * len(COLUMNS))
    for subject in paper_subjects():
        runs = compare([subject], vertices=asked.vertices, degree=asked.degree, steps=asked.steps)
        for row in run_table(subject.name, runs).rows:
            print("| " + " | ".join(row) + " |", flush=True)


if __name__ == "__main__":
    main()
