"""Tests of what every backend must do (service/backend/backend.h, docs/BACKENDS.md), for any system. A test
class for a kind of backend inherits these cases from Conformance and defines how to call its engine:

    command()        the engine's command, without a verb; its answers follow docs/BACKENDS.md
    wait_options()   options that make a job wait in the system's queue; None: there is no queue
    make_away()      makes the system stop answering; come_back() ends that
    speed            how many times slower the system is than a process of this machine

The tests launch real keepers (service/keeper), whose programs are shell scripts that record their start and
the signals that they receive. Each test has its own attempts, with daemon names that no other test uses."""

import concurrent.futures
import json
import pathlib
import random
import secrets
import subprocess
import time

import harness

AWAY = 75

# Records its start and waits until it receives a signal.
PROGRAM = """echo started >> starts
trap 'echo told >> told; exit 0' USR1
touch ready
for ((i = 0; i < 6000; i++)); do sleep 0.05; done"""


class Conformance:
    speed = 1

    # Values that a kind of backend may override.

    def command(self):
        raise NotImplementedError

    def wait_options(self):
        return None

    def make_away(self):
        raise NotImplementedError

    def come_back(self):
        raise NotImplementedError

    def environment(self):
        return harness.environment()

    def setUp(self):
        super().setUp()
        self.daemon = secrets.token_hex(8)
        self.job = 0
        self.launched = []
        self.addCleanup(self.end_all)

    # Questions

    def ask_raw(self, verb, text):
        return subprocess.run([*map(str, self.command()), verb], input=text, capture_output=True, text=True,
                              env=self.environment(), timeout=120)

    def ask(self, verb, **question):
        result = self.ask_raw(verb, json.dumps({"version": 1, **question}))
        self.assertEqual(result.returncode, 0, f"{verb}: {result.stderr}")
        answer = json.loads(result.stdout)
        self.assertEqual(answer["version"], 1)
        return answer

    def order(self, name="job", script=PROGRAM, daemon=None, command=None, options=None):
        """An order for a new job."""
        self.job += 1
        folder = self.path(f"{name} {self.job}")
        folder.mkdir()
        (folder / "program").write_text(f"#!/bin/bash\n{script}\n")
        (folder / "program").chmod(0o755)
        keeper = [str(pathlib.Path(harness.program("sleight-keeper")).resolve()), "--folder", str(folder),
                  "--attempt", "1", "--grace", "1", "--batch", "--", "./program"]
        return {"attempt": {"daemon": daemon or self.daemon, "job": self.job, "epoch": 1},
                "folder": str(folder), "command": command or keeper, "label": f"sleight-{self.job}", "cores": 1,
                "ranks": 0, "memory_bytes": 0, "options": options or {}}

    def launch(self, order):
        self.launched.append(order["attempt"])
        return self.ask("launch", **order)

    def state(self, order):
        return self.ask("state", attempt=order["attempt"])

    def signal(self, order, how):
        return self.ask("signal", attempt=order["attempt"], how=how)["signalled"]

    def listed(self, daemon=None):
        attempts = self.ask("list", daemon=daemon or self.daemon)["attempts"]
        return {(entry["attempt"]["daemon"], entry["attempt"]["job"]): entry["state"] for entry in attempts}

    def lines(self, order, name):
        path = pathlib.Path(order["folder"]) / name
        return path.read_text().splitlines() if path.exists() else []

    def until(self, holds, seconds=20):
        deadline = time.monotonic() + seconds * self.speed
        while not holds():
            self.assertLess(time.monotonic(), deadline, "waited in vain")
            time.sleep(0.02 * self.speed)

    def until_ready(self, order):
        self.until(lambda: (pathlib.Path(order["folder"]) / "ready").exists())

    def until_gone(self, order):
        self.until(lambda: self.state(order)["state"] in ("gone", "absent"))

    def end_all(self):
        for attempt in self.launched:
            self.ask_raw("signal", json.dumps({"version": 1, "attempt": attempt, "how": "now"}))
        for attempt in self.launched:
            self.until_gone({"attempt": attempt})

    # Cases

    def test_life(self):
        order = self.order()
        self.assertEqual(self.state(order)["state"], "absent")
        self.assertIn(self.launch(order)["state"], ("waiting", "running"))
        self.until_ready(order)
        self.until(lambda: self.state(order)["state"] == "running")
        self.assertEqual(self.listed(), {(self.daemon, order["attempt"]["job"]): "running"})
        self.assertTrue(self.signal(order, "in_order"))
        self.until_gone(order)
        self.assertEqual(self.state(order)["cause"], "itself")
        record = json.loads((pathlib.Path(order["folder"]) / "attempt.json").read_text())
        self.assertEqual(record["end"]["exit_code"], 0)
        self.assertEqual(self.lines(order, "told"), ["told"])

    def test_launched_again_it_starts_once(self):
        order = self.order()
        self.launch(order)
        self.assertIn(self.launch(order)["state"], ("waiting", "running"))
        self.until_ready(order)
        self.assertEqual(self.launch(order)["state"], "running")
        self.assertTrue(self.signal(order, "in_order"))
        self.until_gone(order)
        self.assertIn(self.launch(order)["state"], ("gone", "absent"))
        time.sleep(0.3 * self.speed)
        self.assertEqual(self.lines(order, "starts"), ["started"])

    def test_launched_by_several_at_once_it_starts_once(self):
        order = self.order()
        self.launched.append(order["attempt"])
        text = json.dumps({"version": 1, **order})
        with concurrent.futures.ThreadPoolExecutor() as several:
            for result in several.map(lambda _: self.ask_raw("launch", text), range(4)):
                self.assertEqual(result.returncode, 0, result.stderr)
        self.until_ready(order)
        time.sleep(0.3 * self.speed)
        self.assertEqual(self.lines(order, "starts"), ["started"])
        self.assertTrue(self.signal(order, "in_order"))
        self.until_gone(order)

    def test_whose_answer_was_lost_it_starts_once(self):
        # The launching process is killed sooner or later.
        dice = random.Random(5)
        order = self.order()
        self.launched.append(order["attempt"])
        for _ in range(4):
            caller = subprocess.Popen([*map(str, self.command()), "launch"], stdin=subprocess.PIPE,
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, text=True,
                                      env=self.environment())
            caller.stdin.write(json.dumps({"version": 1, **order}))
            caller.stdin.close()
            time.sleep(dice.uniform(0, 0.1))
            caller.kill()
            caller.wait()
        self.launch(order)
        self.until_ready(order)
        self.until(lambda: self.state(order)["state"] == "running")
        time.sleep(0.3 * self.speed)
        self.assertEqual(self.lines(order, "starts"), ["started"])
        self.assertTrue(self.signal(order, "now"))
        self.until_gone(order)

    def test_ended_now(self):
        order = self.order(script="trap 'echo told >> told' USR1\ntouch ready\n"
                                  "for ((i = 0; i < 6000; i++)); do sleep 0.05; done")
        self.launch(order)
        self.until_ready(order)
        self.assertTrue(self.signal(order, "in_order"))
        self.until(lambda: self.lines(order, "told"))
        self.assertTrue(self.signal(order, "now"))
        self.until(lambda: self.state(order)["state"] == "gone")

    def test_signals_to_what_is_not_there(self):
        order = self.order(script="exit 3")
        for how in ("in_order", "now"):
            self.assertFalse(self.signal(order, how))
        self.launch(order)
        self.until_gone(order)
        for how in ("in_order", "now"):
            self.assertFalse(self.signal(order, how))

    def test_waiting(self):
        options = self.wait_options()
        if options is None:
            self.skipTest("it has no queue")
        orders = [self.order(options=options) for _ in range(2)]
        for order, how in zip(orders, ("in_order", "now")):
            self.assertEqual(self.launch(order)["state"], "waiting")
            seen = self.state(order)
            self.assertEqual(seen["state"], "waiting")
            self.assertNotEqual(seen["words"], "")
            self.assertTrue(self.signal(order, how))
            self.until_gone(order)
            self.assertEqual(self.lines(order, "starts"), [])
            self.assertIn(self.launch(order)["state"], ("gone", "absent"))

    def test_each_daemon_sees_its_own(self):
        # One name is a prefix of another.
        names = [self.daemon, self.daemon + "a", secrets.token_hex(8)]
        orders = [self.order(daemon=name) for name in names for _ in range(2)]
        for order in orders:
            self.launch(order)
        for name in names:
            self.assertEqual(set(self.listed(name)),
                             {(name, order["attempt"]["job"]) for order in orders
                              if order["attempt"]["daemon"] == name})
        self.assertEqual(self.listed(secrets.token_hex(8)), {})
        # The same number of another daemon is another job.
        stranger = {"attempt": {**orders[0]["attempt"], "daemon": secrets.token_hex(8)}}
        self.assertEqual(self.state(stranger)["state"], "absent")
        self.assertFalse(self.signal(stranger, "now"))

    def test_what_could_not_begin_says_why(self):
        order = self.order(command=["/bin/sh", "-c", "yes a line of words | head -c 100000 >&2; "
                                    "echo the disk is on fire >&2; exit 5"])
        self.launch(order)
        self.until_gone(order)
        for bytes_max in (100, 5000):
            log = self.ask("log", attempt=order["attempt"], folder=order["folder"],
                           bytes_max=bytes_max)["log"]
            self.assertIn("the disk is on fire", log)
            self.assertLessEqual(len(log), bytes_max)
        quiet = self.order()
        self.assertEqual(self.ask("log", attempt=quiet["attempt"], folder=quiet["folder"],
                                  bytes_max=100)["log"], "")

    def test_strange_folders(self):
        for name in ("it's", 'a "job"', "100% $HOME `id`", "%j %x; rm", "-n", "é"):
            order = self.order(name=name, script="pwd > place; exit 0")
            self.launch(order)
            self.until_gone(order)
            self.assertEqual(self.lines(order, "place"), [order["folder"]])

    def test_a_system_that_does_not_answer_is_away(self):
        order = self.order()
        self.launch(order)
        self.until_ready(order)
        another = self.order()
        self.make_away()
        for verb, question in (("state", {"attempt": order["attempt"]}), ("list", {"daemon": self.daemon}),
                               ("signal", {"attempt": order["attempt"], "how": "in_order"}),
                               ("launch", another)):
            result = self.ask_raw(verb, json.dumps({"version": 1, **question}))
            self.assertEqual(result.returncode, AWAY, f"{verb}: {result.stdout}{result.stderr}")
            self.assertNotEqual(result.stderr, "")
        self.come_back()
        self.until(lambda: self.state(order)["state"] == "running")
        self.assertEqual(self.state(another)["state"], "absent")
        self.assertEqual(self.lines(order, "told"), [])

    def test_questions_that_are_none(self):
        order = self.order()
        # Unknown keys are ignored.
        self.assertEqual(self.ask("state", attempt={**order["attempt"], "colour": 1}, hue="red")["state"],
                         "absent")
        right = {"version": 1, **order}
        for verb, question in (("launch", {**right, "version": 2}),
                               ("launch", {key: right[key] for key in right if key != "version"}),
                               ("launch", {**right, "attempt": {"job": 1, "epoch": 1}}),
                               ("launch", {**right, "attempt": {**order["attempt"], "daemon": "A:b"}}),
                               ("state", {"version": 1, "attempt": {**order["attempt"], "job": 0}}),
                               ("state", {"version": 1}), ("dance", {"version": 1})):
            result = self.ask_raw(verb, json.dumps(question))
            self.assertNotIn(result.returncode, (0, AWAY), f"{verb} {question}")
            self.assertNotEqual(result.stderr, "")
        self.assertNotIn(self.ask_raw("state", "no JSON").returncode, (0, AWAY))
        self.assertEqual(self.state(order)["state"], "absent")
