"""What is not the same on POSIX systems and on Windows: locks, and what the package may call.

Windows' side of the locks runs here with a stand-in for its module.
"""

import ast
import fcntl
import importlib.util
import os
import re
import subprocess
import sys
import types
from pathlib import Path

import pytest

import omma
from omma.base.directories import WholeDirectory, abandoned_directories

PACKAGE = Path(omma.__file__).parent
LOCKS = PACKAGE / "base" / "locks.py"


def stand_in_msvcrt():
    """As Windows locks bytes: until the file is closed, other descriptors are refused."""
    module = types.ModuleType("msvcrt")
    module.LK_LOCK, module.LK_NBLCK = 1, 2

    def locking(descriptor, mode, count):
        assert count == 1
        assert os.lseek(descriptor, 0, os.SEEK_CUR) == 0  # bytes are counted from there
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if mode == 1 else fcntl.LOCK_NB))

    module.locking = locking
    return module


def locks_of(system, monkeypatch):
    """The module `omma.base.locks` as that system loads it."""
    with monkeypatch.context() as there:
        if system == "win32":
            there.setitem(sys.modules, "msvcrt", stand_in_msvcrt())
            there.setattr(os, "O_TEMPORARY", 0, raising=False)
        there.setattr(sys, "platform", system)
        spec = importlib.util.spec_from_file_location(f"locks_of_{system}", LOCKS)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    assert hasattr(module, "msvcrt") == (system == "win32")
    assert hasattr(module, "fcntl") == (system != "win32")
    return module


@pytest.fixture(params=["linux", "win32"])
def locks(request, monkeypatch):
    return locks_of(request.param, monkeypatch)


def test_a_file_is_locked_until_it_is_closed(locks, tmp_path):
    path = tmp_path / "lock"
    path.write_bytes(b"some")
    one, other = (os.open(path, os.O_RDWR) for _ in range(2))
    try:
        os.lseek(one, 3, os.SEEK_SET)
        assert locks.lock(one)
        assert not locks.lock(other)
        os.close(one)
        assert locks.lock(other)
    finally:
        os.close(other)
    assert path.read_bytes() == b"some"


def test_a_directory_is_locked_and_renamed(locks, tmp_path):
    path, new = str(tmp_path / "a"), str(tmp_path / "b")
    os.mkdir(path)
    assert locks.is_free(path)
    descriptor = locks.lock_directory(path)
    assert not locks.is_free(path)
    # Nothing of the lock is in the directory.
    assert os.listdir(path) == []
    os.rename(path, new)
    os.close(descriptor)
    os.rename(new, path)
    assert locks.is_free(path)


def test_files_and_directories_are_synced(locks, tmp_path, monkeypatch):
    synced = []
    monkeypatch.setattr(
        os, "fsync", lambda descriptor: synced.append(os.readlink(f"/proc/self/fd/{descriptor}"))
    )
    file = tmp_path / "file"
    file.write_text("x")
    locks.sync(str(file))
    assert synced == [str(file)]
    locks.sync(str(tmp_path))
    assert file.read_text() == "x"


def test_whole_directories_by_windows_locks(tmp_path, monkeypatch):
    """A directory that is written beside its target, with Windows' side of the locks."""
    locks = locks_of("win32", monkeypatch)
    for name in ("is_free", "lock_directory", "sync"):
        monkeypatch.setattr(f"omma.base.directories.{name}", getattr(locks, name))
    target = tmp_path / "out.zarr"
    for text in ("one", "two"):
        whole = WholeDirectory(str(target), "zarr.json")
        Path(whole.temporary, "zarr.json").write_text(text)
        assert abandoned_directories(str(target)) == []
        whole.sync()
        whole.finish()
        whole.discard()
        assert (target / "zarr.json").read_text() == text
    left = WholeDirectory(str(target), "zarr.json")
    os.close(left._lock)  # as the end of its process does
    assert abandoned_directories(str(target)) == [left.temporary]


# Modules of Python that Windows lacks (docs.python.org, "Availability: Unix"), and names in others.
POSIX_MODULES = {
    "fcntl", "termios", "tty", "pty", "pwd", "grp", "resource", "posix", "syslog", "readline",
    "curses", "crypt", "spwd", "nis",
}  # fmt: skip
POSIX_NAMES = {
    "os": "chown chroot confstr ctermid fchdir fchmod fchown fdatasync fork forkpty fpathconf "
    "getegid geteuid getgid getgroups getloadavg getpgid getpgrp getpriority getresuid getsid "
    "getuid initgroups killpg lchown major makedev minor mkfifo mknod nice openpty pathconf pipe2 "
    "posix_fadvise posix_fallocate posix_spawn pread preadv pwrite pwritev register_at_fork "
    "sched_getaffinity sched_setaffinity sched_yield sendfile setegid seteuid setgid setpgid "
    "setpriority setsid setuid statvfs fstatvfs sync sysconf tcgetpgrp ttyname uname wait wait3 "
    "wait4 waitid WNOHANG O_CLOEXEC O_DIRECTORY O_NOFOLLOW O_NONBLOCK O_SYNC O_TMPFILE",
    "signal": "SIGHUP SIGKILL SIGQUIT SIGUSR1 SIGUSR2 SIGALRM SIGCHLD SIGCONT SIGPIPE SIGSTOP "
    "SIGTSTP SIGWINCH alarm pause pthread_kill pthread_sigmask setitimer siginterrupt sigwait",
    "time": "clock_gettime clock_getres clock_settime pthread_getcpuclockid tzset",
    "socket": "AF_UNIX socketpair CMSG_LEN sendmsg recvmsg",
    "select": "poll epoll kqueue",
}
# Behind a question which system it is.
ASKED = {("scene/memory.py", "os.sysconf"), ("base/locks.py", "fcntl")}


def test_the_package_calls_nothing_that_windows_lacks():
    missing = {
        f"{module}.{name}" for module, names in POSIX_NAMES.items() for name in names.split()
    }
    found = set()
    for path in PACKAGE.rglob("*.py"):
        file = path.relative_to(PACKAGE).as_posix()
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
                names = [f"{node.value.id}.{node.attr}"]
            else:
                continue
            found |= {(file, name) for name in names if name in missing or name in POSIX_MODULES}
    assert found == ASKED


# Of C++20 what the standard libraries lack that Omma is built with elsewhere: Emscripten 3.1.6,
# which is libc++ 14, and GCC 12.
LACKING = re.compile(r"\bstd::(ranges::|views::|format\b|jthread\b|source_location\b|expected\b)")


def test_the_engine_uses_what_every_standard_library_has():
    sources = Path(__file__).resolve().parents[2]
    files = [file for folder in ("include", "src", "web") for file in (sources / folder).rglob("*")]
    code = [file for file in files if file.suffix in (".h", ".cpp", ".cu")]
    assert len(code) > 200
    found = [
        (file.relative_to(sources).as_posix(), match[0])
        for file in code
        for match in LACKING.finditer(file.read_text("utf-8"))
    ]
    assert not found


# Loads all of the package where it is refused what Windows lacks. Others are not, which have a side
# of their own for Windows.
WITHOUT_POSIX = """
import builtins, importlib, os, pkgutil, sys
sys.path.insert(0, {tests!r})
import test_other_systems as tests
import pytest
patch = pytest.MonkeyPatch()
for name in list(sys.modules):
    if name.partition(".")[0] == "omma" and name != "omma._core":
        del sys.modules[name]
sys.modules["omma.base.locks"] = tests.locks_of("win32", patch)
import_any = builtins.__import__
refused = []
def guarded(name, of=None, *rest, **more):
    if name in tests.POSIX_MODULES and (of or {{}}).get("__name__", "").startswith("omma"):
        refused.append((name, of["__name__"]))
        raise ModuleNotFoundError(name)
    return import_any(name, of, *rest, **more)
builtins.__import__ = guarded
import omma
left_out = {{"omma.__main__"}}
names = [found.name for found in pkgutil.walk_packages(omma.__path__, "omma.")]
for name in names:
    try:
        if name not in left_out:
            importlib.import_module(name)
    except (ModuleNotFoundError, omma.Error) as error:
        if refused:
            raise
        print("without an optional package:", name, error, file=sys.stderr)
from omma.base import directories
assert "msvcrt" in directories.lock_directory.__globals__
print(len(names), refused)
"""


def test_all_modules_load_without_what_windows_lacks():
    code = WITHOUT_POSIX.format(tests=str(Path(__file__).parent))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    count, refused = done.stdout.split(maxsplit=1)
    assert int(count) > 200
    assert refused == "[]\n"
