"""The same bits on other machines, compilers and C libraries: tools/check-arch, which `make check-arch` prints."""

import subprocess

import pytest
from support import BUILD, REPOSITORY

pytestmark = [pytest.mark.long, pytest.mark.longest, pytest.mark.release]


def test_one_hash_everywhere():
    command = [str(REPOSITORY / "tools/check-arch"), str(BUILD)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    print(done.stdout)
    hashes = [line.split()[-1] for line in done.stdout.splitlines()]
    assert len(hashes) == 10 and len(set(hashes)) == 1


def test_a_difference_is_seen(tmp_path):
    """With contraction to fused multiply-add the hash is another: the comparison can fail."""
    flags = ["-std=c99", "-O2", "-w", "-mfma", "-ffp-contract=fast", f"-I{REPOSITORY}/include", f"-I{BUILD}/generated"]
    sources = [*(REPOSITORY / "lib").glob("*.c"), *(REPOSITORY / "lib").glob("*/*.c")]
    program, hashes = tmp_path / "same_bits", []
    for more in ([], ["-ffp-contract=off"]):
        subprocess.run(["gcc", *flags, *more, "-o", program, REPOSITORY / "tests/arch/same_bits.c", *sources, "-lm"], check=True)
        done = subprocess.run([program], capture_output=True, text=True, check=False)
        if done.returncode < 0:
            pytest.skip("this processor has no fused multiply-add")
        hashes.append(done.stdout)
    assert hashes[0] != hashes[1]
