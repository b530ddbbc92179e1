"""talus-acquire with a cure taken out, to see a test fail that the whole program passes.

    path = uncured(tmp_path, SYNC_IGNORED)
    with FrameSource(tmp_path / "r", path=path) as source: ...

A cure is taken out as (file, its text, the text without it). The file alone is compiled anew and linked with the build's own objects.
"""

import subprocess

from support import BUILD, REPOSITORY, make_variable

SOURCES = sorted(path.relative_to(REPOSITORY) for pattern in ("*.c", "*/*.c") for path in REPOSITORY.glob(f"apps/acquire/{pattern}"))
FLAGS = ("-std=c99", "-D_POSIX_C_SOURCE=200809L", "-D_FILE_OFFSET_BITS=64", "-pthread", "-O1")

# the disk's answer is not looked at
SYNC_IGNORED = (("record/file_pair.c", "    fail(pair, which, errno);\n    __atomic_store_n(&pair->sync_failed, 1, __ATOMIC_RELEASE);\n    return -1;\n",
                 "    return 0;\n"),)  # fmt: skip
# the writer is held up for 2.3 s, and the ring of events has one place: no cure, but what one is needed for
EVENTS_HELD_UP = (("record/session.c", "clock_sleep_until(next);", "clock_sleep_until(s->second == 1 ? next + 2300000000 : next);"),
                  ("record/watch.c", "EVENTS_RING = 1 << 10", "EVENTS_RING = 1"))  # fmt: skip
# an event that finds the ring full is left out
EVENT_LEFT_OUT = (("record/watch.c", "while (!ring_push(&w->events, item)) {", "while (!ring_push(&w->events, item)) {\n    return;"),)
# the sources' lines are written one source after the other, whatever their stamps
NOT_MERGED = (("record/writer.c", "(chosen < 0 || at < earliest)", "(chosen < 0 || 0 * at)"),)
# nobody compares what was read with what was written
NO_BALANCE = (("record/account.c", "  return apart(a->read,", "  return 0 * apart(a->read,"),
              ("record/account.c", "         apart(a->frames,", "         0 * apart(a->frames,"))  # fmt: skip
# a stamp at the end of time is never the earliest
LAST_STAMP_WAITS_TOLD = (("record/writer.c", "(chosen < 0 || at < earliest)", "at < earliest"),)
LAST_STAMP_WAITS = (*LAST_STAMP_WAITS_TOLD, *NO_BALANCE)
# what an interface had counted when it vanished is not compared with what was read
NO_TALLY = (("source/source_can.c", "v->state = s->finishing ? SETTLED : JUST_GONE;", "v->state = SETTLED;"),)
# the socket is bound to the interface, and its error is all that is read when that has gone
BOUND = (("source/can_port.c", "all = {.can_family = AF_CAN};", "all = {.can_family = AF_CAN, .can_ifindex = port->index};"),
         ("source/source_can.c", "if (n < 0 && errno != EAGAIN && errno != EWOULDBLOCK) return -1;", "if (n < 0) return 0;"), *NO_TALLY)  # fmt: skip
# an interface's counters are asked for while it is there, and its last word is not heard
LAST_WORD_NOT_HEARD = (("record/watch.c", "if (n > 0 && concerns(w, i, &event))", "if (0 && concerns(w, i, &event))"), *NO_TALLY)
# another interface that takes the name is not followed
OTHER_NOT_FOLLOWED = (("source/source_can.c", "      adopt(s, now);\n    }\n  }", "    }\n  }"),)
# what the adapter's stamps were set to is not set again
STAMPS_KEPT = (("source/link.c", "  if (before->asked && if_index", "  if (0 && if_index"),)
# the emergency stop goes to the interface that had the name at the start
STOP_TO_THE_FIRST = (("source/can_port.c", "const int now = can_port_look(port);", "const int now = 0;"),)
# whether the button is pressed at the start is not looked at
BUTTON_NOT_READ = (("record/session.c", "if (source->pressed == 1 && s->settings->play)", "if (0 && source->pressed == 1 && s->settings->play)"),)
# the word that the drives are to hold is said once
HOLD_SAID_ONCE = (("play/player.c", "!= 0 && clock_mono_ns() < until_ns)", "!= 0 && until_ns == 0)"),)
# an emergency stop that goes out 30 ms late: the thread sleeps, or it works on something else
STOP_SLEEPS = (("play/stop_line.c", "  if (stop->playing) __atomic", "  clock_sleep_until(clock_mono_ns() + 30000000);\n  if (stop->playing) __atomic"),)
STOP_BUSY = (("play/stop_line.c", "  if (stop->playing) __atomic",
              "  for (const int64_t until = clock_mono_ns() + 30000000; clock_mono_ns() < until;) continue;\n  if (stop->playing) __atomic"),)  # fmt: skip
# Data races, for the thread sanitizer to find: between a source's thread and the writer's, the writer's and the disk's, a button's and the player's
RING_RACE = (("source/ring.c", "__atomic_store_n(&ring->head, ring->head + 1, __ATOMIC_RELEASE)", "ring->head++"),)
DISK_RACE = (("record/writer.c", "__atomic_store_n(&w->state[i].handed, w->state[i].frames, __ATOMIC_RELEASE)",
              "w->state[i].handed = w->state[i].frames"),)  # fmt: skip
STOP_RACE = (("play/stop_line.c", "__atomic_store_n(stop->playing, 1, __ATOMIC_RELEASE)", "*stop->playing = 1"),)
SANITIZED = ("-fsanitize=thread", "-fno-omit-frame-pointer", "-g")


def uncured(folder, changes, build=BUILD, flags=()):
    """The program's path. Each text must stand in its file once, so that a change of the source is noticed here. `flags` are what `build`
    was made with besides."""
    folder.mkdir(parents=True, exist_ok=True)
    objects = build / "obj" / (build / "flags").read_text().strip()
    link = {source: objects / source.with_suffix(".o") for source in SOURCES}
    for name in {name for name, _, _ in changes}:
        source = REPOSITORY / "apps/acquire" / name
        text = source.read_text()
        for cure, before in [change[1:] for change in changes if change[0] == name]:
            assert text.count(cure) == 1, (name, cure)
            text = text.replace(cure, before)
        changed = folder / source.name
        changed.write_text(text)
        made = link[source.relative_to(REPOSITORY)] = changed.with_suffix(".o")
        subprocess.run(["gcc", *FLAGS, *flags, f"-I{source.parent}", f"-I{REPOSITORY}/include", f"-I{REPOSITORY}/apps", "-w", "-c", "-o", made, changed], check=True)
    path = folder / "talus-acquire"
    libraries = [objects / "libcommon.a", build / "lib/libtalus.a", *make_variable("APP_LIBS"), *make_variable("GPIOD_LIBS")]
    subprocess.run(["gcc", "-pthread", *flags, "-o", path, *link.values(), *libraries], check=True)
    return path
