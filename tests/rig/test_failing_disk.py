"""talus-acquire on a disk that fails behind the write: the kernel takes every write into its memory, and the device has no room for them.

A file system of 64 MiB lies on a loop device, and that on a sparse file in 1.8 MiB: three and a half seconds of a full bus, so that it is
full in the middle between two syncs. write() succeeds until the end, and fdatasync answers EIO.
"""

import subprocess
import time

import pytest
from recording import LINE, SOURCE, Recording
from test_acquire_plugging import PER_MS
from uncured import SYNC_IGNORED, uncured

pytestmark = [pytest.mark.rig, pytest.mark.release]

SECONDS = 8


class ThinDisk:
    def __init__(self, folder):
        self.folder, self.behind = folder / "disk", folder / "behind"
        self.image = self.behind / "image"
        self.folder.mkdir()
        self.behind.mkdir()

    def make(self):
        subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1856k", "tmpfs", self.behind], check=True)
        with self.image.open("wb") as file:
            file.truncate(64 << 20)
        subprocess.run(["mkfs.ext2", "-q", "-F", "-N", "64", self.image], check=True)

    def mount(self):
        return subprocess.run(["mount", "-o", "loop", self.image, self.folder], check=False, capture_output=True).returncode == 0

    def mount_again(self):
        """What is read now comes from the device, not from the kernel's memory."""
        subprocess.run(["umount", self.folder], check=True)
        assert self.mount()

    def remove(self):
        for folder in (self.folder, self.behind):
            subprocess.run(["umount", folder], check=False, stderr=subprocess.DEVNULL)


@pytest.fixture
def thin_disk(tmp_path):
    disk = ThinDisk(tmp_path)
    disk.make()
    if not disk.mount():
        disk.remove()
        pytest.skip("this kernel has no loop device")
    yield disk
    disk.remove()


def numbers_on(path):
    """The numbers of the frames up to the first line that is not whole."""
    numbers = []
    for line in path.read_text(encoding="ascii", errors="replace").splitlines(keepends=True):
        found = LINE.fullmatch(line)
        if not found:
            break
        numbers.append(int.from_bytes(bytes.fromhex(found[4][:8]), "little"))
    return numbers


@pytest.mark.parametrize("cured", [True, False], ids=["cured", "uncured"])
def test_what_the_disk_confirmed_is_there_and_the_rest_counts_as_lost(vcan, tmp_path, thin_disk, cured, capsys):
    (name,) = vcan()
    path = None if cured else uncured(tmp_path / "uncured", SYNC_IGNORED)
    with Recording(thin_disk.folder / "r", name, path=path) as recording:
        sender = subprocess.Popen([SOURCE, "rate", str(SECONDS), str(PER_MS), name], stdout=subprocess.DEVNULL)
        if cured:
            printed = recording.wait(status=1)
            sender.kill()
            sender.wait()
        else:
            sender.wait()
            time.sleep(0.2)
            printed = recording.stop()
    end, source = recording.end(), recording.at_end(name)
    thin_disk.mount_again()
    there = numbers_on(recording.log)
    with capsys.disabled():
        print(f"\n  read {source['read']}, confirmed {source['synced']}, told lost {end['lost']}; on the disk {len(there)}")
    assert there == list(range(len(there))) and 1000 < len(there) < source["read"]
    if not cured:
        assert "nothing lost" in printed and end["lost"] == 0
        return
    assert f"{recording.log}: Input/output error; the recording ends here" in printed and end["reason"] == "write failed"
    assert source["synced"] <= len(there) and source["read"] == source["synced"] + end["lost"]
    assert end["lost"] == source["not_synced"] + source["not_written"] and source["unexplained"] == 0
    (drop,) = recording.events("drop")
    assert (drop["where"], drop["lost"], drop["after"]) == ("disk", source["not_synced"], source["synced"])
