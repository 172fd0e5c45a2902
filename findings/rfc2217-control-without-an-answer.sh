#!/usr/bin/env bash
# A serial line by RFC 2217: what of a line without modem lines (a pseudo-terminal, many adapters)?
#
# Behaviour: ser2net answers each SET-CONTROL of flow, break, speed, size, parity and stop bits, but
#   none that sets DTR or RTS where the device has no such lines; and a question for them (7, 10) is
#   answered by the question's own code. pyserial's client sets DTR and RTS whenever it opens, waits
#   three seconds for an answer, and gives up: "timeout while waiting for option 'control'". With
#   ?ign_set_control at the end of the URL it opens, and carries bytes both ways.
# Guess before: the server answers with the state that the line has, as RFC 2217 has it ("the access
#   server ... will reply with the current setting"), so the client opens.
# Versions: ser2net 4.3.11 (Debian 12), pyserial 3.5
# Source: RFC 2217, section 3 (SET-CONTROL); serial/rfc2217.py, Serial.open and rfc2217_set_control
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq ser2net=4.3.11-1 libgensio4=2.6.2-4 libyaml-0-2=0.2.5-1 > /dev/null
for each in ./*.deb; do dpkg -x "$each" root; done
python3 -m venv python && python/bin/pip install -q --disable-pip-version-check pyserial==3.5
cat > seen.py << 'PY'
import os, socket, subprocess, sys, threading, time, tty
import warnings

warnings.simplefilter("ignore")  # the client sets its thread up in a way that is deprecated
import serial

near, far = os.openpty()
tty.setraw(far)
with socket.create_server(("127.0.0.1", 0)) as free:
    port = free.getsockname()[1]
with open("line.yaml", "w") as file:
    file.write(
        "%YAML 1.1\n---\nconnection: &line\n"
        f"  accepter: telnet(rfc2217),tcp,127.0.0.1,{port}\n"
        f"  connector: serialdev,{os.ttyname(far)},9600n81,local\n"
    )
server = subprocess.Popen(
    ["root/usr/sbin/ser2net", "-n", "-c", "line.yaml", "-u"], stderr=subprocess.DEVNULL
)
IAC, SB, SE, COM_PORT, SET_CONTROL = 255, 250, 240, 44, 5


def answer_to(value):
    """Return the code by which a SET-CONTROL is answered, None for no answer in a second."""
    line.sendall(bytes([IAC, SB, COM_PORT, SET_CONTROL, value, IAC, SE]))
    try:
        return line.recv(4096)[4]
    except TimeoutError:
        return None


seen = {}
try:
    for _ in range(100):
        try:
            line = socket.create_connection(("127.0.0.1", port), 1.0)
            break
        except OSError:
            time.sleep(0.1)
    with line:
        line.sendall(bytes([IAC, 251, COM_PORT]))
        time.sleep(0.5)
        line.recv(4096)
        names = {1: "no flow control", 6: "break off", 7: "DTR?", 8: "DTR on", 9: "DTR off"}
        names |= {10: "RTS?", 11: "RTS on", 12: "RTS off"}
        for value, name in names.items():
            seen[name] = answer_to(value)
            print(f"SET-CONTROL {value:2} ({name}): {seen[name] or 'no answer'}")
    try:
        serial.serial_for_url(f"rfc2217://127.0.0.1:{port}", 9600)
        seen["opens"] = True
    except serial.SerialException as error:
        seen["opens"] = str(error)
    print("pyserial, plain:", seen["opens"])
    with serial.serial_for_url(f"rfc2217://127.0.0.1:{port}?ign_set_control", 9600, timeout=5) as own:
        own.write(b"there\n")
        there = os.read(near, 100)
        os.write(near, b"back\n")
        back = own.read(5)
    print("pyserial, ?ign_set_control:", there, back)
finally:
    server.terminate()
unanswered = [name for name, code in seen.items() if code is None]
sys.exit(
    unanswered != ["DTR on", "DTR off", "RTS on", "RTS off"]
    or (seen["DTR?"], seen["RTS?"]) != (7, 10)
    or "timeout while waiting for option 'control'" not in seen["opens"]
    or (there, back) != (b"there\n", b"back\n")
)
PY
LD_LIBRARY_PATH=$(dirname "$(find "$folder/root" -name 'libgensio.so*' | head -n 1)") python/bin/python seen.py
