"""A server under attack: each attack says what it expects, and somebody else's page must come after each.

    python3 tests/attack/test_attack.py build/volvis [family]...
"""
import os
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "cli"))

import asks  # noqa: E402
import frames  # noqa: E402
import heads  # noqa: E402
from attack import Failed, make  # noqa: E402
from harness import write_ball  # noqa: E402
from patience import Patient  # noqa: E402
from served import Server  # noqa: E402


def run_family(server, family, attacks):
    print(f"[ RUN      ] {family}", flush=True)
    failures, n, began = [], 0, time.monotonic()
    for attack in attacks:
        n += 1
        try:
            make(server, attack)
        except (Failed, OSError) as why:
            failures.append(f"{attack.name}: {why}")
        if server.process.poll() is not None:
            sys.exit(f"{attack.name}: the server has ended: {server.process.communicate()[1].decode()[-3000:]}")
    print("\n".join(failures[:20]), end="\n" if failures else "")
    verdict = "[  FAILED  ]" if failures else "[       OK ]"
    print(f"{verdict} {family} ({n} attacks, {time.monotonic() - began:.1f} s{f', {len(failures)} failed' if failures else ''})", flush=True)
    return n, len(failures)


def attack_by(modules, server, wanted):
    """How many attacks there were, and how many failed."""
    n = failed = 0
    for module in modules:
        for family in module.FAMILIES:
            name = f"{module.__name__}.{family.__name__}"
            if not wanted or name in wanted:
                more = run_family(server, name, family(server))
                n, failed = n + more[0], failed + more[1]
    assert server.process.poll() is None, "the server has ended"
    return n, failed


def ready(server):
    server.own_cookie, server.asker = server.cookie(), None
    return server


def wait_for(patient):
    print("[ RUN      ] patience", flush=True)
    failures = patient.check()
    print("\n".join(failures), end="\n" if failures else "")
    print("[  FAILED  ] patience" if failures else f"[       OK ] patience ({len(patient.all)} attacks)", flush=True)
    return len(patient.all), len(failures)


def attack_all(wanted):
    write_ball("ball.nrrd", 16)
    asks.prepare()
    words = ("ball.nrrd", "--root", ".", "--upload", "1MB")
    with Server(*words, verb="serve") as server:
        ready(server)
        patient = Patient(server) if not wanted or "patience" in wanted else None
        counts = [attack_by((heads, frames), server, wanted)]
        with Server(*words, "--limit", f"session_bytes={asks.ROOM}", verb="serve", state="asked") as other:  # whose World changes, while those who wait should see none of it
            counts.append(attack_by((asks,), ready(other), wanted))
        if patient:
            counts.append(wait_for(patient))
        assert server.process.poll() is None, "the server has ended"
    n, failed = (sum(count) for count in zip(*counts))
    print(f"{n} attacks, {failed} of which did what they should not")
    return failed == 0 and n > 0


if __name__ == "__main__":
    os.chdir(tempfile.mkdtemp(prefix="volvis-attack-"))
    sys.exit(0 if attack_all(sys.argv[2:]) else 1)
