"""libcosim, timed: all steps in one call, nothing recorded.  Job on stdin."""

import json
import re
import runpy
import sys
from pathlib import Path
from time import perf_counter, process_time

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

job = json.load(sys.stdin)
tool = runpy.run_path(job["tool"])
log_output_level(CosimLogLevel.ERROR)
num, den = job["period"]
execution = CosimExecution.from_step_size(10**9 * num // den)
slaves = {}
for name, component in job["components"].items():
    slave = CosimLocalSlave(fmu_path=component["fmu"], instance_name=name)
    slaves[name] = execution.add_local_slave(slave)
for name, component in job["components"].items():
    for _, reference, sort, value in component["start"]:
        if sort == "real":
            execution.real_initial_value(slaves[name], reference, float(value))
        else:
            execution.boolean_initial_value(slaves[name], reference, bool(value))
for connection in job["connections"]:
    tool["_connect"](execution, slaves, connection)
observer = CosimObserver.create_last_value()
if job.get("observed"):
    execution.add_observer(observer)
begun = perf_counter(), process_time()
if not execution.step(job["count"]):
    raise SystemExit(f"libcosim stopped: {execution.status()}")
took = min(perf_counter() - begun[0], process_time() - begun[1])
last = [
    observer.last_real_values(slaves[name], [reference])[0]
    for name, _, reference, _ in job["signals"]
    if job.get("observed")
]
status = Path("/proc/self/status").read_text()
told = {
    "seconds": took,
    "steps": job["count"],
    "peak": 1024 * int(re.search(r"VmHWM:\s+(\d+)", status)[1]),
    "last": last,
}
print(json.dumps(told))
