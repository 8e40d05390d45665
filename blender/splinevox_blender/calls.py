# SPDX-License-Identifier: Apache-2.0
"""Calls of the program, whose events (--json) are heard while it works."""
import json
import os
import queue
import shutil
import signal
import subprocess
import tempfile
import threading

import bpy


class Failed(Exception):
    """What the user is told."""


def program():
    """Path of splinevox, as the preferences say or as it is found in PATH."""
    asked = bpy.path.abspath(bpy.context.preferences.addons[__package__].preferences.program)
    found = shutil.which(asked)
    if not found:
        raise Failed("There is no program '%s'. Try: its path in Preferences > Add-ons > splinevox" % asked)
    return found


class Job:
    """One call of the program."""

    def __init__(self, words):
        self.events = queue.Queue()
        self.last = {}
        self.stopped = False
        self.said = tempfile.TemporaryFile()
        self.process = subprocess.Popen([program(), *words, "--json"], stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=self.said, text=True, errors="replace")
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()

    def read(self):
        for line in self.process.stdout:
            try:
                self.events.put(json.loads(line))
            except ValueError:  # of a program that is not splinevox
                continue

    def told(self):
        """What came since the last call."""
        while not self.events.empty():
            self.last = self.events.get()
            yield self.last

    def running(self):
        return self.reader.is_alive() or self.process.poll() is None

    def stop(self):
        """As Ctrl-C does: what is finished stays. Once: a second signal would end it at once."""
        if self.process.poll() is None and not self.stopped:
            self.stopped = True
            self.process.send_signal(signal.SIGINT if os.name == "posix" else signal.SIGTERM)

    def result(self):
        """The event "result", once it has ended. Throws Failed with the program's own message."""
        self.reader.join()
        code = self.process.wait()
        for _ in self.told():
            pass
        if code == 0 and self.last.get("event") == "result":
            return self.last
        if self.last.get("event") == "error":
            parts = [("Expected: ", "expected"), ("Found: ", "found"), ("Try: ", "try")]
            more = ["%s%s" % (word, self.last[key]) for word, key in parts if self.last.get(key)]
            raise Failed(". ".join(["%s: %s" % (self.last["where"], self.last["what"]), *more]))
        if self.last.get("event") == "interrupted":
            raise Failed("Stopped. The same once more goes on from there")
        self.said.seek(0)
        said = self.said.read().decode(errors="replace").strip()
        raise Failed("%s ended with code %d. %s" % (self.process.args[0], code, said[-300:]))


def progress_text(event):
    """A line for the status bar; None: nothing to show."""
    if event["event"] == "frame":
        return "splinevox: frame %d" % event["frame"]
    if event["event"] == "progress" and "total" in event:
        return "splinevox: %d of %d" % (event["done"], event["total"])
    return event.get("note")


class Calls:
    """An operator that calls the program: with a window beside the user's work, until Esc; else to its end.
    It has begin(context) -> words, and end(context, result) -> what to say."""

    def start(self, context):
        try:
            self.job = Job(self.begin(context))
        except (Failed, ValueError, OSError) as e:
            self.report({"ERROR"}, str(e))
            return False
        return True

    def finish(self, context):
        try:
            self.report({"INFO"}, self.end(context, self.job.result()))
        except (Failed, ValueError) as e:
            self.report({"ERROR"}, str(e))
            return {"CANCELLED"}
        return {"FINISHED"}

    def execute(self, context):
        return self.finish(context) if self.start(context) else {"CANCELLED"}

    def invoke(self, context, event):
        if not self.start(context):
            return {"CANCELLED"}
        self.timer = context.window_manager.event_timer_add(0.2, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC" and event.value == "PRESS":
            self.job.stop()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        for told in self.job.told():
            if text := progress_text(told):
                context.workspace.status_text_set(text + "   (Esc stops it)")
        if self.job.running():
            return {"PASS_THROUGH"}
        context.workspace.status_text_set(None)
        context.window_manager.event_timer_remove(self.timer)
        return self.finish(context)
