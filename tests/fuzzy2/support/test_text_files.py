"""A file is written whole or not at all, whatever happens on the way."""

from __future__ import annotations

import errno
import os
import pickle
import signal
import stat
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from fuzzy2.errors import FileNotWritten, MalformedFile
from fuzzy2.support.text_files import made_folder, read_text, write_text, written_whole

BIG = 1_000_000
"""Characters that no buffer holds, so that parts of them reach the disk on the way."""

WRITER = """
import os, signal, sys
from fuzzy2.support.text_files import written_whole
path, letter, how = sys.argv[1:]
for _ in range(20 if how == "often" else 1):
    with written_whole(path) as file:
        file.write(letter * {big})
        if how != "often":
            file.flush()
            os.kill(os.getpid(), signal.Signals[how])
            signal.pause()
"""


def start(path: Path, letter: str, how: str) -> subprocess.Popen[bytes]:
    """Start a process that writes a file of one letter, often or until a signal ends it."""
    program = WRITER.replace("{big}", str(BIG))
    return subprocess.Popen(
        [sys.executable, "-c", program, str(path), letter, how],
        stderr=subprocess.PIPE,
        # Whoever starts the tests in the background ignores Ctrl-C, and children inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler) and None,
    )


def names(directory: Path) -> list[str]:
    return sorted(os.listdir(directory))


def permissions(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def test_text_is_utf_8_with_line_feeds(tmp_path: Path) -> None:
    path = tmp_path / "text"
    write_text("α\nβ\r\n", path)
    assert path.read_bytes() == "α\nβ\r\n".encode()
    assert read_text(path) == "α\nβ\r\n"
    assert names(tmp_path) == ["text"]


def test_a_file_that_is_not_utf_8_is_refused_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "text"
    with written_whole(path, "wb") as file:
        file.write(b"one\ntwo \xff\n")
    with pytest.raises(MalformedFile, match=r"line 2: byte 0xff is not UTF-8"):
        read_text(path)


def test_the_old_file_is_there_until_the_new_one_is_complete(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_text("old")
    with written_whole(path) as file:
        file.write("new" * BIG)
        file.flush()
        assert path.read_text() == "old"
        assert len(names(tmp_path)) == 2
    assert path.read_text() == "new" * BIG
    assert names(tmp_path) == ["text"]


@pytest.mark.parametrize("error", [ValueError, OSError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("old", [None, "old"])
def test_any_exception_leaves_what_was_there(
    tmp_path: Path, old: str | None, error: type[BaseException]
) -> None:
    path = tmp_path / "text"
    if old is not None:
        path.write_text(old)
    raised = error("on the way")

    def write_a_part() -> None:
        with written_whole(path) as file:
            file.write("new" * BIG)
            file.flush()
            raise raised

    with pytest.raises(error) as caught:
        write_a_part()
    assert caught.value is raised
    assert names(tmp_path) == ([] if old is None else ["text"])
    assert old is None or path.read_text() == old


@pytest.mark.parametrize("function", ["os.fsync", "os.replace", "os.fchmod"])
def test_an_error_of_the_system_names_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, function: str
) -> None:
    path = tmp_path / "text"
    path.write_text("old")

    def full(*arguments: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", *map(str, arguments[:1]))

    def full_without_name(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(function, full if function == "os.replace" else full_without_name)
    with pytest.raises(OSError, match="No space left") as caught:
        write_text("new", path)
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, str(path))
    assert caught.value.filename2 is None
    assert names(tmp_path) == ["text"]
    assert path.read_text() == "old"


def test_an_error_about_another_file_keeps_its_name(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError) as caught, written_whole(tmp_path / "text"):
        (tmp_path / "another").read_text()
    assert caught.value.filename == str(tmp_path / "another")
    assert names(tmp_path) == []


@pytest.mark.parametrize(
    ("place", "message"),
    [
        ("none/text", "No such file or directory; make the folder first"),
        ("file/text", "Not a directory; a part of the path is a file, not a folder"),
        ("", "Is a directory; it is a folder"),
    ],
)
def test_a_place_where_no_file_can_be_is_refused(tmp_path: Path, place: str, message: str) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(FileNotWritten, match=message) as caught:
        write_text("new", tmp_path / place)
    assert caught.value.filename == str(tmp_path / place)
    assert names(tmp_path) == ["file"]


def test_a_file_that_is_marked_read_only_stays(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_text("old")
    path.chmod(0o444)
    with pytest.raises(FileNotWritten, match="allow writing") as caught:
        write_text("new", path)
    assert caught.value.filename == str(path)
    assert names(tmp_path) == ["text"]
    assert path.read_text() == "old"


def test_a_read_only_folder_is_refused() -> None:
    """In a process that is nobody's, for root may write to every folder."""
    program = (
        "import os, sys; from fuzzy2.support.text_files import write_text; "
        "os.geteuid() or os.setuid(65534); write_text('new', sys.argv[1])"
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "text")
        path.write_text("old")
        path.chmod(0o666)
        os.chmod(folder, 0o555)
        done = subprocess.run([sys.executable, "-c", program, path], capture_output=True, text=True)
        os.chmod(folder, 0o755)
        assert path.read_text() == "old"
    message = f"FileNotWritten: {path}: Permission denied; allow writing to it and its folder"
    assert message in done.stderr.splitlines()[-1]


@pytest.mark.parametrize("mode", [0o600, 0o644, 0o660, 0o777])
def test_a_file_that_is_replaced_keeps_its_permissions(tmp_path: Path, mode: int) -> None:
    path = tmp_path / "text"
    path.write_text("old")
    path.chmod(mode)
    with written_whole(path) as file:
        # Nobody may read the new one on the way who may not read the old one.
        (draft,) = (entry for entry in tmp_path.iterdir() if entry != path)
        assert permissions(draft) == mode
        file.write("new")
    assert permissions(path) == mode


@pytest.mark.skipif(os.geteuid() != 0, reason="only root gives files away")
def test_a_file_that_is_replaced_keeps_its_owner(tmp_path: Path) -> None:
    path = tmp_path / "text"
    path.write_text("old")
    os.chown(path, 1234, 1235)
    write_text("new", path)
    assert (path.stat().st_uid, path.stat().st_gid) == (1234, 1235)


@pytest.mark.parametrize("umask", [0o022, 0o077, 0o002])
def test_a_new_file_has_the_permissions_of_the_umask(tmp_path: Path, umask: int) -> None:
    before = os.umask(umask)
    try:
        write_text("new", tmp_path / "text")
    finally:
        os.umask(before)
    assert permissions(tmp_path / "text") == 0o666 & ~umask


@pytest.mark.parametrize("exists", [True, False])
def test_behind_links_the_file_is_written(tmp_path: Path, exists: bool) -> None:
    (tmp_path / "there").mkdir()
    target, first, link = tmp_path / "there" / "text", tmp_path / "first", tmp_path / "link"
    if exists:
        target.write_text("old")
    first.symlink_to("there/text")
    link.symlink_to("first")
    write_text("new", link)
    assert target.read_text() == "new"
    assert (os.readlink(link), os.readlink(first)) == ("first", "there/text")
    assert names(tmp_path / "there") == ["text"]


def test_links_in_a_circle_are_refused(tmp_path: Path) -> None:
    (tmp_path / "one").symlink_to("other")
    (tmp_path / "other").symlink_to("one")
    with pytest.raises(OSError, match="symbolic links") as caught:
        write_text("new", tmp_path / "one")
    assert caught.value.filename == str(tmp_path / "one")
    assert names(tmp_path) == ["one", "other"]


@pytest.mark.parametrize("character", ["n", "ä"])
def test_the_longest_name_can_be_written(tmp_path: Path, character: str) -> None:
    longest = os.pathconf(tmp_path, "PC_NAME_MAX")
    path = tmp_path / (character * (longest // len(character.encode())))
    write_text("new", path)
    assert path.read_text() == "new"
    with pytest.raises(OSError, match="name too long") as caught:
        write_text("new", tmp_path / ("n" * (longest + 1)))
    assert caught.value.filename == str(tmp_path / ("n" * (longest + 1)))
    assert names(tmp_path) == [path.name]


def test_no_file_of_another_name_is_touched(tmp_path: Path) -> None:
    for name in ("text.part", ".text.part", ".text.draft", "text.tmp", f".{'00' * 8}.part"):
        (tmp_path / name).write_text(name)
    others = {path: path.stat() for path in tmp_path.iterdir()}
    write_text("new", tmp_path / "text")
    for path, status in others.items():
        assert path.read_text() == path.name
        assert path.stat() == status


def test_two_processes_at_once_leave_one_whole_file(tmp_path: Path) -> None:
    path = tmp_path / "text"
    write_text("a" * BIG, path)
    writers = [start(path, letter, "often") for letter in "bc"]
    seen = set()
    while any(writer.poll() is None for writer in writers):
        seen.add(read_text(path))
    for writer in writers:
        assert writer.communicate()[1] == b""
        assert writer.returncode == 0
    seen.add(read_text(path))
    assert seen <= {letter * BIG for letter in "abc"}
    assert names(tmp_path) == ["text"]


@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM", "SIGKILL"])
def test_a_process_that_is_ended_in_the_middle_leaves_the_old_file(
    tmp_path: Path, how: str
) -> None:
    path = tmp_path / "text"
    path.write_text("old")
    writer = start(path, "b", how)
    writer.communicate()
    assert writer.returncode == -signal.Signals[how]
    assert path.read_text() == "old"
    # Ctrl-C leaves time to clear away; whoever saves next does it otherwise.
    left = [name for name in names(tmp_path) if name != "text"]
    assert len(left) == (how != "SIGINT")
    write_text("new", tmp_path / "another")
    assert names(tmp_path) == ["another", "text"]


def test_a_folder_is_synchronized_after_its_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Else the new name may be lost with the power, and the old content with it."""
    kinds, synchronize = [], os.fsync

    def noted(descriptor: int) -> None:
        kinds.append((stat.S_ISDIR(os.fstat(descriptor).st_mode), names(tmp_path)))
        synchronize(descriptor)

    monkeypatch.setattr("os.fsync", noted)
    write_text("new", tmp_path / "text")
    assert [is_folder for is_folder, _ in kinds] == [False, True]
    assert kinds[1][1] == ["text"]


def test_threads_at_once_leave_one_whole_file(tmp_path: Path) -> None:
    path = tmp_path / "text"

    def save(letter: str) -> None:
        for _ in range(50):
            write_text(letter * BIG, path)
            assert read_text(path) in {each * BIG for each in "abcd"}

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(save, "abcd"))
    assert names(tmp_path) == ["text"]


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    assert made_folder(tmp_path / "one" / "two") == made_folder(tmp_path / "one" / "two")
    (tmp_path / "file").write_text("in the way")
    for place in ("file", "file/below"):
        with pytest.raises(FileNotWritten, match="is a file, not a folder"):
            made_folder(tmp_path / place)


def test_the_error_crosses_processes_whole() -> None:
    error = FileNotWritten(errno.ENOSPC, "No space left on device", "a")
    again = pickle.loads(pickle.dumps(error))
    assert (str(again), again.errno, again.filename) == (str(error), errno.ENOSPC, "a")


def test_a_disk_that_is_full_leaves_the_old_file(tmp_path: Path) -> None:
    """A limit on the size of files stands for the disk."""
    path = tmp_path / "text"
    path.write_text("old")
    program = (
        "import resource, signal, sys; from fuzzy2.support.text_files import write_text; "
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
        f"resource.setrlimit(resource.RLIMIT_FSIZE, ({BIG // 2}, {BIG // 2})); "
        f"write_text('b' * {BIG}, sys.argv[1])"
    )
    done = subprocess.run([sys.executable, "-c", program, path], capture_output=True, text=True)
    assert f"FileNotWritten: {path}: File too large; " in done.stderr.splitlines()[-1]
    assert names(tmp_path) == ["text"]
    assert path.read_text() == "old"


@pytest.mark.parametrize("mode", ["w", "wb"])
def test_a_device_is_written_to_directly(mode: str, tmp_path: Path) -> None:
    content = "new" * BIG if mode == "w" else b"new" * BIG
    with written_whole("/dev/null", mode) as file:  # type: ignore[arg-type] # one of the two
        file.write(content)
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)
    # Also behind a link.
    (tmp_path / "full").symlink_to("/dev/full")
    with (
        pytest.raises(OSError, match="No space left") as caught,
        written_whole(tmp_path / "full", mode) as file,  # type: ignore[arg-type]
    ):
        file.write(content)
    assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, str(tmp_path / "full"))
    assert names(tmp_path) == ["full"]


def test_a_pipe_is_written_to_directly(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_text("through", tmp_path / "pipe")
    assert os.read(reader, 100) == b"through"
    os.close(reader)
    assert names(tmp_path) == ["pipe"]


@pytest.mark.parametrize("by_its_name", [True, False])
def test_standard_output_is_written_to_directly(tmp_path: Path, by_its_name: bool) -> None:
    """A shell that sent it to a file reads that very file, not one that took its name."""
    path = tmp_path / "output"
    program = (
        "import sys; from fuzzy2.support.text_files import write_text; "
        "write_text('new', sys.argv[1])"
    )
    with path.open("w+") as output:
        subprocess.run(
            [sys.executable, "-c", program, str(path) if by_its_name else "/dev/stdout"],
            stdout=output,
            check=True,
        )
        output.seek(0)
        assert output.read() == "new"
    assert names(tmp_path) == ["output"]
