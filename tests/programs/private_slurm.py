"""A private Slurm on this host, as root: munge with its own key and socket, slurmctld, and a slurmd for each
of two nodes, with all files in one folder. One node has the host's name, and mpirun starts ranks there
itself. The other is unknown to mpirun, which uses srun to start its daemon there, as on a real cluster. This
Slurm listens on its own ports and affects no other Slurm. Closing it ends all its processes and jobs, which
have SLURM_CONF in their environment."""

import os
import pathlib
import secrets
import shutil
import signal
import socket
import subprocess
import time

START_S_MAX = 60
END_S_MAX = 20

# cred_expire also determines how long a requeued job waits (default: 120 s). config_overrides: the machine
# may have fewer cores than named. Jobs of `urgent` pre-empt other jobs, which have a grace of half a minute,
# or none.
CONFIGURATION = """
ClusterName=private
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
CredType=cred/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool-%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd-%n.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SwitchType=switch/none
MpiDefault=none
SlurmdParameters=config_overrides
ReturnToService=2
SchedulerParameters=sched_interval=5,bf_interval=5,batch_sched_delay=1
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
PreemptType=preempt/partition_prio
PreemptMode=REQUEUE
{extra}
NodeName={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=2 State=UNKNOWN
NodeName=other NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[2]} CPUs=2 State=UNKNOWN
PartitionName=grace Nodes={host},other Default=YES MaxTime=INFINITE State=UP PriorityTier=1 GraceTime=30
PartitionName=no_grace Nodes={host},other MaxTime=INFINITE State=UP PriorityTier=1 GraceTime=0
PartitionName=urgent Nodes={host},other MaxTime=INFINITE State=UP PriorityTier=10 PreemptMode=OFF
"""


def missing_programs():
    found = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"
    return [name for name in ("munged", "slurmctld", "slurmd", "sbatch", "scancel", "scontrol")
            if shutil.which(name, path=found) is None]


def free_ports(count):
    probes = [socket.socket() for _ in range(count)]
    for probe in probes:
        probe.bind(("127.0.0.1", 0))
    ports = [probe.getsockname()[1] for probe in probes]
    for probe in probes:
        probe.close()
    return ports


class PrivateSlurm:
    """Use it in a `with`. Slurm's commands need `environment` to reach it."""

    def __init__(self, folder, environment, extra=""):
        self.folder = pathlib.Path(folder)
        self.host = socket.gethostname().split(".")[0]
        self.environment = {**environment, "SLURM_CONF": str(self.folder / "slurm.conf"),
                            "PATH": environment["PATH"] + ":/usr/sbin:/sbin"}
        (self.folder / "slurm.conf").write_text(CONFIGURATION.format(
            host=self.host, folder=self.folder, ports=free_ports(3), extra=extra))
        # slurmd exits at once with a plugin "disabled", and must not mount anything.
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n")
        for name in ("state", f"spool-{self.host}", "spool-other"):
            (self.folder / name).mkdir()
        key = self.folder / "munge.key"
        key.write_bytes(secrets.token_bytes(128))
        key.chmod(0o400)
        self.daemons = {}

    def __enter__(self):
        try:
            self.start("munged", "munged", "--foreground", "--force",
                       f"--key-file={self.folder}/munge.key",
                       f"--socket={self.folder}/munge.socket",
                       f"--pid-file={self.folder}/munged.pid",
                       f"--seed-file={self.folder}/munged.seed",
                       f"--log-file={self.folder}/munged.log")
            self.wait_for("munged", (self.folder / "munge.socket").exists)
            self.start_controller("-i")
            for node in (self.host, "other"):
                self.start(node, "slurmd", "-D", "-N", node)
                self.wait_for(node, lambda node=node: "State=IDLE" in self.call(
                    "scontrol", "show", "node", node).stdout)
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_):
        self.close()

    def start(self, name, *command):
        with open(self.folder / f"{name}.output", "w") as output:
            self.daemons[name] = subprocess.Popen(command, env=self.environment,
                                                  stdin=subprocess.DEVNULL, stdout=output,
                                                  stderr=output, start_new_session=True)

    def start_controller(self, *options):
        self.start("slurmctld", "slurmctld", "-D", *options)
        self.wait_for("slurmctld", lambda: self.call("scontrol", "ping").returncode == 0)

    def kill(self, name):
        """Kills a daemon as if its machine had lost power."""
        self.daemons[name].kill()
        self.daemons[name].wait()

    def kill_steps(self):
        """Kills everything that slurmd has started and watches. With slurmd itself, that is a whole node."""
        for process in self.processes():
            try:
                if pathlib.Path(f"/proc/{process}/comm").read_text().startswith("slurmstepd"):
                    os.kill(process, signal.SIGKILL)
            except OSError:
                pass  # it ended just now

    def wait_for(self, name, is_up):
        deadline = time.monotonic() + START_S_MAX
        while not is_up():
            if self.daemons[name].poll() is not None or time.monotonic() > deadline:
                raise RuntimeError(f"{name} does not start:\n{self.said_by(name)}")
            time.sleep(0.1)

    def said_by(self, name):
        return (self.folder / f"{name}.output").read_text(errors="replace")[-5000:]

    def call(self, *command, check=False):
        result = subprocess.run([str(part) for part in command], env=self.environment, timeout=60,
                                capture_output=True, text=True)
        if check and result.returncode != 0:
            raise RuntimeError(f"{command}: {result.returncode}: {result.stderr}")
        return result

    def submit(self, *arguments):
        """Submits a job and returns its number."""
        return self.call("sbatch", "--parsable", *arguments, check=True).stdout.strip()

    def job(self, number):
        """Output of `scontrol show job` as a dictionary of texts."""
        words = self.call("scontrol", "-o", "show", "job", number, check=True).stdout.split()
        return dict(word.split("=", 1) for word in words if "=" in word)

    def processes(self):
        """Process ids of this Slurm, including its jobs."""
        own = f"SLURM_CONF={self.folder}/slurm.conf".encode()
        found = []
        for folder in pathlib.Path("/proc").glob("[0-9]*"):
            try:
                if own in (folder / "environ").read_bytes().split(b"\0"):
                    found.append(int(folder.name))
            except OSError:
                pass  # it ended just now
        return found

    def close(self):
        """Kills everything at once. Returns when no process is left."""
        deadline = time.monotonic() + END_S_MAX
        while left := self.processes():
            if time.monotonic() > deadline:
                raise RuntimeError(f"processes that cannot be ended: {left}")
            for process in left:
                try:
                    os.kill(process, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            time.sleep(0.1)
        for daemon in self.daemons.values():
            daemon.wait()
