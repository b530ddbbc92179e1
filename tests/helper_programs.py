"""The small programs of tests/programs/, which show what programs share.

from helper_programs import helper

done = helper("model_copy", path, status=2)
"""

import subprocess

from support import BUILD


def helper(name, *arguments, status=0, **options):
    """Runs build/tests/NAME, demands its exit status, and returns what subprocess.run does."""
    program = BUILD / "tests" / name
    assert program.exists(), f"{program} is not built"
    command = [str(program), *map(str, arguments)]
    if "input" not in options:
        options = {"stdin": subprocess.DEVNULL, **options}
    options = {"capture_output": True, "timeout": 300, **options}
    done = subprocess.run(command, check=False, **options)
    assert done.returncode == status, (
        f"{' '.join(command)}\nstatus {done.returncode}, expected {status}\n{done.stderr!r}"
    )
    return done


def complaint(name, *arguments, status=2, **options):
    """The one line on standard error with which the program must end."""
    text = helper(name, *arguments, status=status, **options).stderr.decode()
    lines = text.splitlines()
    assert len(lines) == 1 and text.endswith("\n"), text
    assert lines[0].startswith(f"{name}: ")
    return lines[0].removeprefix(f"{name}: ")
