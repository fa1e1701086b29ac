"""Drives the test model through FMPy, FMI 2.0 and 3.0: what a host should do and what not.

Arguments: the FMI 2.0 file and the FMI 3.0 file. Each bad call runs in its own process, so an
abort would be seen as one; here it must be a status.
"""

import ctypes
import multiprocessing
import sys
import tempfile

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
PANIC = 3


class Host:
    """One instance of the test model with statuses instead of exceptions."""

    def __init__(self, path, token=None, logging=False):
        self.description = fmpy.read_model_description(path)
        self.vr = {v.name: v.valueReference for v in self.description.modelVariables}
        self.three = self.description.fmiVersion.startswith("3")
        self.folder = tempfile.mkdtemp()
        fmpy.extract(path, self.folder)
        cls = FMU3Slave if self.three else FMU2Slave
        self.fmu = cls(
            guid=token or self.description.guid or self.description.instantiationToken,
            unzipDirectory=self.folder,
            modelIdentifier=self.description.coSimulation.modelIdentifier,
            instanceName="probe",
        )
        self.messages = []  # (status, category, text)
        if self.three:
            self.fmu.instantiate(loggingOn=logging, logMessage=self._log3)
        else:
            # The logger is variadic in C. Declared with one text more, it gets what a message
            # "%s" is followed by; on x86-64 Linux both kinds of call pass it alike.
            kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int,
                                    ctypes.c_char_p, ctypes.c_char_p, ctypes.c_char_p)
            self.logger = kind(self._log2)
            self.callbacks = fmi2CallbackFunctions()
            self.callbacks.logger = ctypes.cast(self.logger, fmi2CallbackLoggerTYPE)
            self.fmu.instantiate(loggingOn=logging, callbacks=self.callbacks)

    def _log2(self, _environment, _name, status, category, form, message):
        assert form == b"%s", form
        self.messages.append((status, category.decode(), message.decode()))

    def _log3(self, _environment, status, category, message):
        self.messages.append((status, category.decode(), message.decode()))

    def raw(self, name, *arguments):
        """Calls a C function past FMPy's own checks and returns the status."""
        prefix = "fmi3" if self.three else "fmi2"
        return getattr(self.fmu.dll, prefix + name)(ctypes.c_void_p(self.fmu.component), *arguments)

    def set(self, name, value, function=None):
        reference = (ctypes.c_uint32 * 1)(self.vr[name] if isinstance(name, str) else name)
        kinds = {v.name: v.type for v in self.description.modelVariables}
        integer = function or kinds.get(name) in ("Integer", "Int32")
        values = (ctypes.c_int32 * 1)(int(value)) if integer else (ctypes.c_double * 1)(value)
        usual = ("SetInteger", "SetInt32") if integer else ("SetReal", "SetFloat64")
        one = ctypes.c_size_t(1)
        arguments = [reference, one, values] + ([one] if self.three else [])
        return self.raw(function or usual[self.three], *arguments)

    def get(self, name):
        reference = [self.vr[name]]
        return (self.fmu.getFloat64(reference) if self.three else self.fmu.getReal(reference))[0]

    def state(self, verb, *arguments):
        name = f"{verb}FMUState"
        if not self.three:
            name = name.replace("State", "state").replace("deserial", "deSerial")
        return getattr(self.fmu, name)(*arguments)

    def initialize(self, stop=None):
        if self.three:
            self.fmu.enterInitializationMode(startTime=0.0, stopTime=stop)
        else:
            self.fmu.setupExperiment(startTime=0.0, stopTime=stop)
            self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()

    def step(self, time, size):
        d = ctypes.c_double
        if not self.three:
            return self.raw("DoStep", d(time), d(size), ctypes.c_int(1))
        flags = [ctypes.c_bool() for _ in range(3)]
        last = d()
        return self.raw("DoStep", d(time), d(size), ctypes.c_bool(True),
                        *[ctypes.byref(f) for f in flags], ctypes.byref(last))


def ready(path, **arguments):
    host = Host(path, **arguments)
    host.initialize(stop=10.0)
    assert host.set("u", 2.0) == OK
    assert host.step(0.0, 0.1) == OK
    return host


def refused(path, action, words, status=ERROR, then=OK):
    """The call gets its status, says why, changes no output, and the instance goes on."""
    host = ready(path)
    before = host.get("x"), host.get("count"), host.get("time")
    got = action(host)
    assert got == status, f"status {got}, expected {status}"
    if not (status == DISCARD or status == WARNING):
        assert any(words in text for _, _, text in host.messages), host.messages
    assert (host.get("x"), host.get("count"), host.get("time")) == before
    got = host.step(0.1, 0.1)
    assert got == then, f"afterwards {got}, expected {then}"


def failing_step(code):
    def action(host):
        assert host.set("param.fail", code) == OK
        return host.step(0.1, 0.1)
    return action


def wrong_token(path):
    try:
        Host(path, token="{00000000-0000-0000-0000-000000000000}")
    except Exception as error:
        assert "nstantiate" in str(error), error
        return
    raise AssertionError("a wrong token was accepted")


def before_init(path):
    host = Host(path)
    assert host.step(0.0, 0.1) == ERROR
    host.initialize()
    assert host.step(0.0, 0.1) == OK


def past_stop(path):
    host = Host(path)
    host.initialize(stop=0.15)
    assert host.step(0.0, 0.1) == OK
    assert host.step(0.1, 0.1) == ERROR
    assert host.step(0.1, 0.05) == OK


def damaged_state(path):
    host = ready(path)
    state = host.state("get")
    data = host.state("serialize", state)
    host.step(0.1, 0.1)
    bad = bytearray(data)
    bad[-1] ^= 1
    name = "DeserializeFMUState" if host.three else "DeSerializeFMUstate"
    for case, words in [(bytes(bad), "damaged"), (data[:-3], "announces"), (b"nonsense" * 9, "not a saved")]:
        out = ctypes.c_void_p()
        kind = (ctypes.c_char, ctypes.c_ubyte)[host.three]
        got = host.raw(name, (kind * len(case)).from_buffer_copy(case), ctypes.c_size_t(len(case)), ctypes.byref(out))
        assert got == ERROR and not out.value, got
        assert any(words in m[2] for m in host.messages), host.messages
    x = host.get("x")
    host.state("set", state)
    assert host.step(0.1, 0.1) == OK
    assert host.get("x") == x
    restored = host.state("deserialize", data)
    host.state("set", restored)
    assert host.step(0.1, 0.1) == OK
    assert host.get("x") == x
    host.state("free", state)
    host.state("free", restored)


def percent_in_message(path):
    host = ready(path, logging=True)
    assert host.set("param.fail", 1) == OK
    assert host.step(0.1, 0.1) == WARNING
    assert (WARNING, "logStatusWarning", "100 % warned, as asked: %s %n") in host.messages


def after_failure(path):
    host = ready(path)
    state = host.state("get")
    assert failing_step(PANIC)(host) == ERROR
    assert any("panicked, as asked" in m[2] for m in host.messages), host.messages
    assert host.step(0.1, 0.1) == ERROR
    host.state("set", state)
    assert host.step(0.1, 0.1) == OK
    assert failing_step(2)(host) == ERROR
    host.fmu.reset()
    host.initialize()
    assert host.step(0.0, 0.1) == OK
    host.fmu.terminate()
    host.fmu.freeInstance()


def probes(path):
    output, nan = ctypes.c_double(), float("nan")
    yield "wrong token", wrong_token, ()
    yield "step before initialisation", before_init, ()
    yield "step past the stop time", past_stop, ()
    yield "damaged state", damaged_state, ()
    yield "percent sign in a message", percent_in_message, ()
    yield "life after a panic", after_failure, ()
    for name, action, words in [
        ("unknown value reference", lambda h: h.set(10_000, 1.0), "unknown value reference"),
        ("wrong type", lambda h: h.set("u", 1, ("SetInteger", "SetInt32")[h.three]), "of type"),
        ("h = 0", lambda h: h.step(0.1, 0.0), "positive"),
        ("h < 0", lambda h: h.step(0.1, -0.1), "positive"),
        ("h = NaN", lambda h: h.step(0.1, nan), "positive"),
        ("time runs ahead", lambda h: h.step(0.2, 0.1), "communication point"),
        ("set an output", lambda h: h.set("x", 1.0), "not for the host"),
        ("set the time", lambda h: h.set("time", 1.0), "not for the host"),
        ("set a fixed parameter", lambda h: h.set("param.x0", 1.0), "fixed parameter"),
        ("NaN into an input", lambda h: h.set("u", nan), "cannot be NaN"),
        ("infinity into an input", lambda h: h.set("u", float("inf")), "cannot be inf"),
        ("parameter out of range", lambda h: h.set("param.gain", 11.0), "outside [-10, 10]"),
        ("null pointers", lambda h: h.raw(
            ("SetReal", "SetFloat64")[h.three], None, ctypes.c_size_t(1), None,
            *([ctypes.c_size_t(1)] if h.three else [])), "null pointer"),
        ("initialise twice", lambda h: h.raw("ExitInitializationMode"), "not allowed"),
    ]:
        yield name, refused, (action, words)
    yield "step too long", refused, (lambda h: h.step(0.1, 0.2), "", DISCARD)
    if fmpy.read_model_description(path).fmiVersion.startswith("3"):
        yield "event mode", refused, (lambda h: h.raw("EnterEventMode"), "not offered")
        yield "two values for one variable", refused, (lambda h: h.raw(
            "SetFloat64", (ctypes.c_uint32 * 1)(h.vr["u"]), ctypes.c_size_t(1),
            (ctypes.c_double * 2)(1.0, 1.0), ctypes.c_size_t(2)), "2 values for 1")
    for code, words in [(2, "failed, as asked"), (3, "panicked, as asked"), (4, "not finite")]:
        yield f"failure {code}", refused, (failing_step(code), words, ERROR, ERROR)


def run(path):
    names = [name for name, _, _ in probes(path)]
    for i, name in enumerate(names):
        # fork keeps the lambdas; each case gets a fresh copy of this process.
        process = multiprocessing.get_context("fork").Process(target=one, args=(path, i))
        process.start()
        process.join(60)
        assert process.exitcode == 0, f"{path}: '{name}' ended with {process.exitcode}"
    print(f"{path}: {len(names)} probes")


def one(path, i):
    _, body, arguments = list(probes(path))[i]
    body(path, *arguments)


def simulate(path):
    problems = validate_fmu(path)
    assert not problems, problems
    u = np.array([(0.0, 1.0), (10.0, 1.0)], dtype=[("time", np.float64), ("u", np.float64)])
    for size in (0.1, 0.05, 0.03, 0.01):
        result = fmpy.simulate_fmu(path, stop_time=1.0, output_interval=size, input=u,
                                   start_values={"param.x0": 0.5, "param.gain": 2.0},
                                   output=["x", "count"])
        expected = 0.5
        for _ in range(10):
            expected += 0.1 * 2.0 * 1.0
        full = result["time"][-1] > 0.99
        assert result["x"][-1] == expected or not full, (size, result[-1], expected)
        assert result["x"][0] == 0.5
        assert result["count"][-1] == 10.0, (size, result[-1])


if __name__ == "__main__":
    for file in sys.argv[1:]:
        simulate(file)
        run(file)
