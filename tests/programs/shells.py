"""Real shells in a terminal of their own. A test requests completion like a person: it types a line and
presses the key that lists the candidates."""

import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time

TIMEOUT_S = 30
PROMPT = "P> "
# A wide terminal, so that columns are separated by spaces and no pager appears.
ROWS, COLUMNS = 200, 240


class Shell:
    """A shell without personal settings. `setup` runs first; `list_key` lists."""

    def __init__(self, argv, setup, folder, env):
        self.count = 0
        self.unread = ""
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            os.chdir(folder)
            os.execvpe(argv[0], argv, {**env, "TERM": "dumb"})
        fcntl.ioctl(self.terminal, termios.TIOCSWINSZ, struct.pack("HHHH", ROWS, COLUMNS, 0, 0))
        for line in setup:
            self.command(line)

    def close(self):
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)
        os.close(self.terminal)

    def command(self, line):
        """Runs a command and returns its terminal output."""
        self.count += 1
        # The typed line shows the mark in two parts.
        self.type(f"{line}; echo DONE''{self.count}.\n")
        return self.read_until(f"DONE{self.count}.")

    def listed(self, line):
        """Returns the shell's list with the cursor behind `line`."""
        self.type(line + "\t")
        self.type("\x18m")  # prints the mark, as set up
        text = self.read_until("MARK.")
        # Until zsh shows the line again, the terminal itself would read the next key.
        self.read_until(PROMPT)
        self.unread = PROMPT + self.unread
        self.type("\x15\n")  # the line is given up
        return [row.strip() for row in text.splitlines()
                if row.strip() and PROMPT.strip() not in row]

    def type(self, text):
        data = text.encode()
        while data:
            data = data[os.write(self.terminal, data):]

    def read_until(self, mark):
        deadline = time.monotonic() + TIMEOUT_S
        while mark not in self.unread:
            if not select.select([self.terminal], [], [], max(0, deadline - time.monotonic()))[0]:
                raise AssertionError(f"no {mark} in: {self.unread!r}")
            self.unread += os.read(self.terminal, 65536).decode(errors="replace")
        text, _, self.unread = self.unread.partition(mark)
        return re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|\r|\x07", "", text)


def bash(setup, folder, env):
    return Shell(["bash", "--norc", "--noprofile", "-i"],
                 [f"PS1='{PROMPT}'",
                  "bind 'set enable-bracketed-paste off' 'set bell-style none'",
                  "bind 'set page-completions off'; bind 'set completion-query-items 0'",
                  "bind 'TAB: possible-completions'; bind -x '\"\\C-xm\": echo; echo MARK.'",
                  *setup], folder, env)


def zsh(setup, folder, env):
    return Shell(["zsh", "-f", "-i"],
                 [f"PS1='{PROMPT}'; unsetopt beep promptcr promptsp zle_bracketed_paste",
                  "autoload -Uz compinit; LISTMAX=1000; unset zle_bracketed_paste",
                  "show-mark() { zle -I; print; print MARK. }; zle -N show-mark",
                  "bindkey -e; bindkey '^I' list-choices; bindkey '^Xm' show-mark", *setup],
                 folder, env)


class Fish:
    """fish prints its candidates without a terminal."""

    def __init__(self, setup, folder, env):
        self.setup, self.folder, self.env = setup, folder, env

    def close(self):
        pass

    def command(self, line):
        self.setup = [*self.setup, line]

    def listed(self, line):
        return self.all_listed([line])[0]

    def all_listed(self, lines):
        """Returns `listed` of each line, from one fish."""
        asked = [f"echo NEXT; complete -C {quoted_for_fish(line)}" for line in lines]
        result = subprocess.run(["fish", "--no-config", "-c", "\n".join([*self.setup, *asked])],
                                cwd=self.folder, env=self.env, capture_output=True, text=True,
                                timeout=TIMEOUT_S, stdin=subprocess.DEVNULL)
        if result.stderr:
            raise AssertionError(result.stderr)
        return [part.splitlines()
                for part in re.split("^NEXT\n", result.stdout, flags=re.MULTILINE)[1:]]


def quoted_for_fish(text):
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"
