# SPDX-License-Identifier: Apache-2.0
"""A real Slurm on this machine, for as long as a `with` lasts: slurmctld and slurmd with a
configuration of their own, in a folder of their own, on the loopback address alone."""
import contextlib
import getpass
import os
import shutil
import signal
import socket
import subprocess
import sys
import time

NODE = "octet0"
CONFIGURATION = """
ClusterName=octet
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
# A task that is sent back waits until its credential is over: two minutes, unless told otherwise.
AuthInfo=cred_expire=5
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerType=sched/builtin
SchedulerParameters=batch_sched_delay=0,sched_interval=1,sched_min_interval=0
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/completed.log
MailProg=/bin/true
KillWait=2
MinJobAge=3600
MpiDefault=none
ReturnToService=2
SlurmdParameters=config_overrides
NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={daemon} CPUs={cpus} RealMemory={memory}
PartitionName=all Nodes={node} Default=YES State=UP
"""


def can_run():
    """Are its programs here, and may this user start them?"""
    return (all(shutil.which(p, path=os.environ["PATH"] + ":/usr/sbin")
                for p in ("slurmctld", "slurmd", "sbatch", "scontrol", "squeue"))
            and os.geteuid() == 0)


def _free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Slurm:
    """The cluster: one node of some processors."""

    def __init__(self, folder, cpus, memory=4000):
        self.folder, self._processes = folder, []
        for name in ("state", "spool"):
            os.makedirs(os.path.join(folder, name))
        controller, daemon = _free_ports(2)
        self.environment = {**os.environ, "SLURM_CONF": os.path.join(folder, "slurm.conf"),
                            "PATH": os.environ["PATH"] + ":/usr/sbin"}
        with open(self.environment["SLURM_CONF"], "w") as file:
            file.write(CONFIGURATION.format(host=socket.gethostname(), user=getpass.getuser(),
                                            folder=folder, controller=controller, daemon=daemon,
                                            node=NODE, cpus=cpus, memory=memory))

    def start(self):
        for command in (["slurmctld", "-D", "-c"], ["slurmd", "-D", "-N", NODE]):
            self._processes.append(subprocess.Popen(
                command, env=self.environment, stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True))
        deadline = time.monotonic() + 60
        while "idle" not in self.run("sinfo", "-h", "-o", "%t", check=False):
            if time.monotonic() > deadline or any(p.poll() is not None for p in self._processes):
                raise RuntimeError("Slurm does not start:\n" + self.log("slurmctld.log")
                                   + self.log("slurmd.log"))
            time.sleep(0.2)

    def stop(self):
        with contextlib.suppress(RuntimeError, subprocess.SubprocessError):
            self.run("scancel", "--state=RUNNING", "--signal=KILL", "-u", getpass.getuser(),
                     check=False)
        for process in reversed(self._processes):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGTERM)
        for process in self._processes:
            try:
                process.wait(15)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()

    def log(self, name):
        with contextlib.suppress(OSError):
            with open(os.path.join(self.folder, name)) as file:
                return file.read()
        return ""

    def run(self, *command, check=True, **options):
        done = subprocess.run(command, capture_output=True, text=True, env=self.environment,
                              timeout=60, **options)
        if check and done.returncode != 0:
            raise RuntimeError(f"{command}: {done.stderr}")
        return done.stdout

    def tasks(self, state=None):
        """Tasks that are not over: "12_3" and state, one each."""
        lines = self.run("squeue", "-h", "-r", "-o", "%i %T").splitlines()
        found = [line.split() for line in lines]
        return [(task, s) for task, s in found if state is None or s == state]

    def __enter__(self):
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()


if __name__ == "__main__":  # a cluster to play with: one_machine_slurm.py FOLDER
    with Slurm(os.path.abspath(sys.argv[1]), os.cpu_count()) as slurm:
        print("export SLURM_CONF=" + slurm.environment["SLURM_CONF"], flush=True)
        with contextlib.suppress(KeyboardInterrupt):
            signal.pause()
