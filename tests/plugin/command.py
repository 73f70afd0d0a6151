# SPDX-License-Identifier: Apache-2.0
"""What the tests of the real command share: running it, and folders that must stay empty."""
import concurrent.futures
import os
import resource
import signal
import subprocess
import sys
import tempfile

DATA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "data")
SAMPLES = os.path.join(DATA, "..", "..", "samples")
PREFIX = "octetvdb: "
AT_ONCE = 6  # seconds: two on a machine at rest, and what other tests take of a loaded one
TIME_LIMIT = 300  # seconds; a hang is a failure


class Command:
    """The octetvdb under test."""

    def __init__(self, path):
        self.path = os.path.abspath(path)

    @staticmethod
    def _quietly(arguments, progress):
        """Work that takes longer on a loaded machine would tell of its progress on stderr."""
        told = ["--progress", progress] if progress and "--progress" not in arguments else []
        return [*told, *map(str, arguments)]

    def run(self, *arguments, progress="none", **options):
        options = {"capture_output": True, "text": True, "errors": "replace",
                   "timeout": TIME_LIMIT, "stdin": subprocess.DEVNULL, **options}
        return subprocess.run([self.path, *self._quietly(arguments, progress)], **options)

    def start(self, *arguments, progress="none", **options):
        options = {"stdin": subprocess.DEVNULL, "stdout": subprocess.PIPE,
                   "stderr": subprocess.PIPE, "text": True, **options}
        return subprocess.Popen([self.path, *self._quietly(arguments, progress)], **options)

    @property
    def sanitized(self):
        """Built with AddressSanitizer: slower, and memory cannot be limited."""
        with open(self.path, "rb") as file:
            return b"__asan_init" in file.read()


def processor_seconds(pid):
    """What a process has used so far, its threads together."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def stop(process, sent=signal.SIGTERM):
    """Sends a signal and waits for the end: how much processor time that took, which says the same
    on a busy machine."""
    ended = resource.getrusage(resource.RUSAGE_CHILDREN)
    before = processor_seconds(process.pid)
    process.send_signal(sent)
    process.communicate(timeout=TIME_LIMIT)
    now = resource.getrusage(resource.RUSAGE_CHILDREN)
    return now.ru_utime + now.ru_stime - ended.ru_utime - ended.ru_stime - before


def from_arguments():
    """The command that the first argument names, taken off for unittest."""
    return Command(sys.argv.pop(1))


def in_parallel(function, items):
    """[function(item), ...] on all processors; the work is done in other processes."""
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(function, items))


def temporary_folder():
    return tempfile.TemporaryDirectory(prefix="octetvdb-test-")


def complaint(result):
    """Why the answer to bad input is not what it has to be; None when it is: exit code 2, nothing on
    stdout and one line on stderr."""
    if result.returncode != 2:
        return f"exit code {result.returncode}: {result.stderr[-2000:]}"
    if result.stdout:
        return f"wrote to stdout: {result.stdout[:200]}"
    if not result.stderr.startswith(PREFIX) or result.stderr.count("\n") != 1:
        return f"not one line that begins with {PREFIX!r}: {result.stderr[-2000:]}"
    return None
