"""Goal: deploy/kubernetes/sleight-kubernetes asks kubectl what it should, and makes of its answers what
docs/BACKENDS.md states. Method: a stand-in for kubectl that gives written answers in turn and notes what it is
asked. The answers are written after MPI Operator's types; no cluster has been asked."""

import json
import os
import pathlib
import subprocess

import harness
from harness import ProgramTest

AWAY = 75
ATTEMPT = {"daemon": "abcdefgh", "job": 17, "epoch": 3}
NAME = "sleight-abcdefgh-17-3"
LAUNCHER = f"training.kubeflow.org/job-name={NAME},training.kubeflow.org/job-role=launcher"
STAND_IN = """#!/usr/bin/python3
import json, pathlib, sys
folder = pathlib.Path(__file__).parent
asked = folder / "asked"
calls = json.loads(asked.read_text()) if asked.exists() else []
answer = json.loads((folder / "answers").read_text())[len(calls)]
calls.append({"arguments": sys.argv[1:], "text": sys.stdin.read() if "-f" in sys.argv else ""})
asked.write_text(json.dumps(calls))
print(answer.get("out", ""), end="")
print(answer.get("err", ""), end="", file=sys.stderr)
sys.exit(answer.get("code", 0))
"""


def condition(kind, status="True", reason="", message=""):
    return {"type": kind, "status": status, "reason": reason, "message": message,
            "lastTransitionTime": "2024-05-01T12:00:00Z", "lastUpdateTime": "2024-05-01T12:00:00Z"}


def mpijob(*conditions, attempt=ATTEMPT, active=None, suspend=False, ended=False, **labels):
    name = f"sleight-{attempt['daemon']}-{attempt['job']}-{attempt['epoch']}"
    own = {f"sleight.service/{key}": str(value) for key, value in attempt.items()}
    return {"apiVersion": "kubeflow.org/v2beta1", "kind": "MPIJob",
            "metadata": {"name": name, "uid": "0d9c", "labels": {**own, **labels},
                         "annotations": {"sleight.service/ended": "yes"} if ended else {}},
            "spec": {"runPolicy": {"suspend": suspend}},
            "status": {"conditions": list(conditions),
                       "replicaStatuses": {"Launcher": {"active": active} if active else {}}}}


CREATED = condition("Created", reason="MPIJobCreated", message=f"MPIJob default/{NAME} is created.")
RUNNING = condition("Running", reason="MPIJobRunning", message=f"MPIJob default/{NAME} is running.")
PODS = {"items": [{"metadata": {"name": f"{NAME}-launcher-x7k2p"}, "status": {"phase": "Running"}}]}


def says(thing):
    return {"out": json.dumps(thing)}


class Kubernetes(ProgramTest):
    def setUp(self):
        super().setUp()
        self.path("kubectl").write_text(STAND_IN)
        self.path("kubectl").chmod(0o755)

    def ask(self, verb, answers, code=0, environment=None, **question):
        self.path("answers").write_text(json.dumps(answers))
        self.path("asked").unlink(missing_ok=True)
        program = pathlib.Path(harness.arguments.source).resolve() / "deploy/kubernetes/sleight-kubernetes"
        result = subprocess.run(
            [program, verb], input=json.dumps({"version": 1, **question}), capture_output=True, text=True,
            timeout=60, env={**os.environ, "KUBECTL": str(self.path("kubectl")), **(environment or {})})
        self.assertEqual(result.returncode, code, result.stderr)
        self.calls = json.loads(self.path("asked").read_text()) if self.path("asked").exists() else []
        self.assertEqual(len(self.calls), len(answers), "every answer was asked for")
        self.words = result.stderr
        return json.loads(result.stdout) if code == 0 else None

    def arguments(self, call):
        words = self.calls[call]["arguments"]
        self.assertEqual(words[0], "--request-timeout=30s")
        return words[1:]

    def order(self, **changes):
        return {"attempt": ATTEMPT, "folder": "/data/state/jobs/17", "label": "sleight-17", "cores": 4, "ranks": 0,
                "memory_bytes": 8_000_000_000, "command": ["/usr/bin/sleight-keeper", "--folder", "a b"],
                "options": {"image": "registry/sleight:1", "claim": "state", "mount": "/data"}, **changes}

    def made(self):
        self.assertEqual(self.arguments(0), ["create", "-f", "-"])
        return json.loads(self.calls[0]["text"])

    def test_launch(self):
        seen = self.ask("launch", [{"out": "created"}, says(mpijob(CREATED))], **self.order())
        self.assertEqual(seen["state"], "waiting")
        job = self.made()
        self.assertEqual((job["apiVersion"], job["kind"]), ("kubeflow.org/v2beta1", "MPIJob"))
        self.assertEqual(job["metadata"]["name"], NAME)
        self.assertEqual(job["metadata"]["labels"], {"sleight.service/daemon": "abcdefgh",
                                                     "sleight.service/job": "17", "sleight.service/epoch": "3"})
        self.assertEqual(job["spec"]["runPolicy"]["backoffLimit"], 0)
        self.assertEqual(set(job["spec"]["mpiReplicaSpecs"]), {"Launcher"})
        launcher = job["spec"]["mpiReplicaSpecs"]["Launcher"]
        self.assertEqual((launcher["replicas"], launcher["restartPolicy"]), (1, "Never"))
        pod = launcher["template"]["spec"]
        container, = pod["containers"]
        self.assertEqual(container["command"], ["/usr/bin/sleight-keeper", "--folder", "a b"])
        self.assertEqual(container["workingDir"], "/data/state/jobs/17")
        self.assertEqual(container["resources"]["limits"], {"cpu": "4", "memory": "8000000000"})
        self.assertEqual(container["volumeMounts"], [{"name": "state", "mountPath": "/data"}])
        self.assertEqual(pod["volumes"][0]["persistentVolumeClaim"], {"claimName": "state"})

    def test_launch_with_ranks(self):
        order = self.order(ranks=4)
        order["options"] = {"queue": "users", "claim": "other", "ssh_mount": "/keys"}
        self.ask("launch", [{"out": "created"}, says(mpijob(CREATED))], **order, environment={
            "SLEIGHT_KUBERNETES_IMAGE": "i", "SLEIGHT_KUBERNETES_CLAIM": "c", "SLEIGHT_KUBERNETES_MOUNT": "/data/",
            "SLEIGHT_KUBERNETES_NAMESPACE": ""})
        job = self.made()
        self.assertEqual(job["metadata"]["labels"]["kueue.x-k8s.io/queue-name"], "users")
        self.assertTrue(job["spec"]["runLauncherAsWorker"])
        self.assertEqual(job["spec"]["sshAuthMountPath"], "/keys")
        replicas = job["spec"]["mpiReplicaSpecs"]
        self.assertEqual(replicas["Worker"]["replicas"], 3)
        for kind in ("Launcher", "Worker"):
            container, = replicas[kind]["template"]["spec"]["containers"]
            self.assertEqual(container["resources"]["requests"], {"cpu": "1", "memory": "2000000000"})
            self.assertEqual(container["image"], "i")
        self.assertNotIn("command", replicas["Worker"]["template"]["spec"]["containers"][0])

    def test_launched_again_it_is_left_alone(self):
        exists = {"code": 1, "err": "Error from server (AlreadyExists): error when creating \"STDIN\": "
                                    f"mpijobs.kubeflow.org \"{NAME}\" already exists"}
        seen = self.ask("launch", [exists, says(mpijob(CREATED, RUNNING))], **self.order())
        self.assertEqual(seen["state"], "running")

    def test_refusals(self):
        self.ask("launch", [{"code": 1, "err": "Error from server (Forbidden): cannot create mpijobs"}], 1,
                 **self.order())
        self.assertIn("Forbidden", self.words)
        wrong = [("image", self.order(options={"claim": "c", "mount": "/data"})),
                 ("colour", self.order(options={"colour": "red"})),
                 ("not below", self.order(folder="/database/jobs/17")),
                 ("epoch", self.order(attempt={**ATTEMPT, "epoch": 0})),
                 ("too long", self.order(attempt={**ATTEMPT, "daemon": "a" * 32, "job": 10 ** 15}))]
        for words, order in wrong:
            self.ask("launch", [], 1, **order)
            self.assertIn(words, self.words)

    def test_states(self):
        failed = condition("Failed", reason="BackoffLimitExceeded")
        was_running = condition("Running", status="False")
        suspended = condition("Suspended", reason="MPIJobSuspended")
        for job, expected in [
                (mpijob(), ("waiting", "itself")), (mpijob(CREATED), ("waiting", "itself")),
                (mpijob(CREATED, RUNNING, active=1), ("running", "itself")),
                (mpijob(CREATED, was_running, condition("Succeeded", reason="MPIJobSucceeded")),
                 ("gone", "itself")),
                (mpijob(CREATED, was_running, failed), ("gone", "itself")),
                (mpijob(CREATED, was_running, condition("Failed", reason="MPIJobEvicted")), ("gone", "taken")),
                (mpijob(CREATED, suspended, suspend=True), ("waiting", "itself")),
                (mpijob(CREATED, RUNNING, suspend=True, ended=True, active=1), ("running", "itself")),
                (mpijob(CREATED, was_running, suspended, suspend=True, ended=True), ("gone", "itself"))]:
            seen = self.ask("state", [says(job)], attempt=ATTEMPT)
            self.assertEqual((seen["state"], seen["cause"]), expected, job)
        self.assertEqual(self.arguments(0), ["get", "mpijob", NAME, "--ignore-not-found", "-o", "json"])
        self.assertEqual(self.ask("state", [{"out": ""}], attempt=ATTEMPT)["state"], "absent")

    def test_signal_in_order(self):
        answer = self.ask("signal", [says(mpijob(CREATED, RUNNING)), says(PODS), {}], attempt=ATTEMPT,
                          how="in_order")
        self.assertTrue(answer["signalled"])
        self.assertEqual(self.arguments(1), ["get", "pods", "-o", "json", "-l", LAUNCHER])
        self.assertEqual(self.arguments(2), ["exec", f"{NAME}-launcher-x7k2p", "-c", "sleight", "--", "kill",
                                             "-USR1", "1"])

    def check_ended(self, answers, **question):
        self.assertTrue(self.ask("signal", answers, attempt=ATTEMPT, **question)["signalled"])
        patch = self.arguments(2)
        self.assertEqual(patch[:4], ["patch", "mpijob", NAME, "--type=merge"])
        self.assertEqual(json.loads(patch[5]), {
            "metadata": {"annotations": {"sleight.service/ended": "yes"}}, "spec": {"runPolicy": {"suspend": True}}})
        self.assertEqual(self.arguments(3)[:2], ["delete", "pods"])

    def test_ended_now_and_while_it_waits(self):
        self.check_ended([says(mpijob(CREATED, RUNNING)), says(PODS), {}, {}], how="now")
        self.check_ended([says(mpijob(CREATED)), says({"items": []}), {}, {}], how="in_order")

    def test_signals_to_what_is_not_there(self):
        for answer in ({"out": ""}, says(mpijob(CREATED, condition("Succeeded")))):
            self.assertFalse(self.ask("signal", [answer], attempt=ATTEMPT, how="now")["signalled"])

    def test_list(self):
        other = {**ATTEMPT, "job": 18}
        odd = mpijob(CREATED, attempt={**ATTEMPT, "job": 19})
        del odd["metadata"]["labels"]["sleight.service/job"]
        answer = self.ask("list", [says({"items": [mpijob(CREATED, RUNNING), mpijob(CREATED, attempt=other), odd]})],
                          daemon="abcdefgh")
        self.assertEqual([(entry["attempt"], entry["state"]) for entry in answer["attempts"]],
                         [(ATTEMPT, "running"), (other, "waiting")])
        self.assertEqual(self.arguments(0), ["get", "mpijobs", "-o", "json", "-l",
                                             "sleight.service/daemon=abcdefgh"])
        self.ask("list", [], 1, daemon="a,b=c")

    def test_log(self):
        answer = self.ask("log", [{"out": "x" * 5000 + "the end"}], attempt=ATTEMPT, folder="/data/f", bytes_max=100)
        self.assertEqual(len(answer["log"]), 100)
        self.assertTrue(answer["log"].endswith("the end"))
        answer = self.ask("log", [{"code": 1, "err": "Error from server (BadRequest): ImagePullBackOff"}],
                          attempt=ATTEMPT, folder="/data/f")
        self.assertIn("ImagePullBackOff", answer["log"])

    def test_a_cluster_that_does_not_answer_is_away(self):
        for words in ("Unable to connect to the server: dial tcp 10.0.0.1:6443: i/o timeout",
                      "The connection to the server localhost:8080 was refused - did you specify the right host?",
                      "Error from server (ServiceUnavailable): the server is currently unable"):
            for verb, question in (("list", {"daemon": "abcdefgh"}), ("launch", self.order()),
                                   ("signal", {"attempt": ATTEMPT})):
                self.ask(verb, [{"code": 1, "err": words}], AWAY, **question)
        self.ask("list", [], AWAY, daemon="abcdefgh", environment={"KUBECTL": "/nowhere/kubectl"})

    def test_says_that_it_was_never_on_a_cluster(self):
        source = pathlib.Path(harness.arguments.source).resolve() / "deploy/kubernetes"
        said = subprocess.run([source / "sleight-kubernetes", "--help"], capture_output=True, text=True).stdout
        self.assertIn("never on a cluster", said.replace("\n", " "))
        self.assertIn("never run on a cluster", (source / "README.md").read_text())


if __name__ == "__main__":
    harness.main()
