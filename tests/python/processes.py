"""Python programs in processes of their own: to be interrupted, to end, to fork.

Programs are given as text and say on stdout how far they are. Nobody waits for ever: what is not
over after a time that no machine needs is killed, and the test fails.
"""

import signal
import subprocess
import sys
import threading

# Far above what any of the programs take on a slow and busy machine.
PATIENCE_S = 600


class Program:
    """A running program; use it in a ``with`` statement."""

    def __init__(self, text, *arguments):
        self.process = subprocess.Popen(
            [sys.executable, "-W", "ignore", "-c", text, *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip

    def __enter__(self):
        self.watchdog = threading.Timer(PATIENCE_S, self.process.kill)
        self.watchdog.start()
        return self

    def __exit__(self, *raised):
        self.watchdog.cancel()
        self.process.kill()
        self.process.communicate()

    def line(self):
        """The next line on stdout, without its end; '' where there comes none."""
        return self.process.stdout.readline().rstrip("\n")

    def interrupt(self):
        """What Ctrl-C does."""
        self.process.send_signal(signal.SIGINT)

    def end(self):
        """Exit code (negative: the signal that it died of) and what is left of stdout, stderr."""
        # Not `communicate`, which loses what `line` has read ahead.
        out, err = self.process.stdout.read(), self.process.stderr.read()
        return self.process.wait(), out, err
