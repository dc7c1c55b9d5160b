"""What the process of runs writes is whole lines, whatever interrupts it."""

import json
import signal
import subprocess
import time

from hairpipe import child

LINES = 3000  # a pipe holds them unread
SENDER = f"""
import signal
from hairpipe.app.page.runs import send
sending = False
def interrupt(*_):
    global sending
    if sending:
        sending = False
        raise KeyboardInterrupt
signal.signal(signal.SIGINT, interrupt)
print("ready", flush=True)
for number in range({LINES}):
    try:
        sending = True
        send({{"number": number}})
        sending = False
    except KeyboardInterrupt:
        pass
"""


def test_an_interrupt_never_cuts_a_line():
    command, environment = child.command(SENDER), child.environment()
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment) as process:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        while process.poll() is None:
            process.send_signal(signal.SIGINT)
            time.sleep(0.0002)
        numbers = [json.loads(line)["number"] for line in process.stdout]
    assert len(numbers) > 50 and numbers == sorted(set(numbers))
