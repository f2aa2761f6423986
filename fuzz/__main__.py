# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`make fuzz`: each campaign for its share of the time; a finding is told with the key that brings it back.

`python -m fuzz KEY`, with a key that was told, tries that case alone, with its traceback.
"""

import argparse
import random
import resource
import sys
import time

from fuzz import bags, frames, texts
from fuzz.campaign import Case, run

CAMPAIGNS: dict[str, Case] = {"frames": frames.case, "bags": bags.case, "texts": texts.case}
_MEMORY = 4 << 30
"""Bytes that the whole campaign may take: more than that is a finding (MemoryError)."""


def main() -> int:
    """Run the campaigns; return 1 if there were findings."""
    parser = argparse.ArgumentParser("fuzz", description=__doc__)
    parser.add_argument("key", nargs="?", help="of one case, such as 'bags 1 17'")
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=time.time_ns() % 10**9, help="of all chance; drawn if not given")
    options = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    if options.key:
        print(CAMPAIGNS[options.key.split()[0]](random.Random(options.key)))
        return 0
    print(f"seed {options.seed}")
    found = False
    for name, case in CAMPAIGNS.items():
        tally = run(name, case, options.seed, sys.maxsize, options.seconds / len(CAMPAIGNS))
        print(f"{name}: {tally.outcomes.total()} cases")
        for outcome, count in sorted(tally.outcomes.items()):
            print(f"  {outcome}: {count}")
        for finding in tally.findings[:10]:
            print(f"  python -m fuzz {finding}")
        found = found or bool(tally.findings)
    return int(found)


if __name__ == "__main__":
    sys.exit(main())
