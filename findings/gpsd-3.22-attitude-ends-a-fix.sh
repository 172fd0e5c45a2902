#!/usr/bin/env bash
# Does gpsd show where a vessel is, wherever its attitude ($PASHR) stands among its sentences?
#
# Behaviour: gpsd takes the sentence that came last with a new time for the end of a set, and learns
#   which that is as it goes. With RMC, GGA, VTG, PASHR of one time, then HDT, it reports an attitude
#   (ATT) for each set, and no position (TPV) after the first two. With RMC, PASHR, GGA, VTG it
#   reports both for each set. With PASHR first TPV is there, and ATT has no pitch in it.
# Guess before: the order within a set only moves the moment of the report.
# Versions: gpsd 3.22-4.1+deb12u1 (Debian 12; Ubuntu 22.04 has 3.22 too); pynmea2 1.19.0 (checksums)
# Source: gpsd's drivers/driver_nmea0183.c, register_fractional_time and cycle_continue
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get download -qq gpsd=3.22-4.1+deb12u1 libgps28=3.22-4.1+deb12u1 > /dev/null
for each in ./*.deb; do dpkg -x "$each" root; done
python3 -m venv python && python/bin/pip install -q --disable-pip-version-check pynmea2==1.19.0
cat > seen.py << 'PY'
import json, socket, subprocess, sys, threading, time

import pynmea2

SETS = 24
RMC = "INRMC,{t},A,2500.{n:05d},N,04500.00000,W,10.00,0.00,010126,,,A"
GGA = "INGGA,{t},2500.{n:05d},N,04500.00000,W,1,08,1.0,0.00,M,0.0,M,,"
VTG = "INVTG,0.00,T,,M,10.00,N,18.52,K,A"
HDT = "INHDT,0.00,T"
PASHR = "PASHR,{t}0,0.00,T,-0.28,-0.60,,,,,0,0"
ORDERS = {
    "PASHR last": (RMC, GGA, VTG, PASHR, HDT),
    "PASHR second": (RMC, PASHR, GGA, VTG, HDT),
    "PASHR first": (PASHR, RMC, GGA, VTG, HDT),
}


def sentence(form, k):
    """Return a sentence of the set k, half a second after the one before."""
    body = form.format(t=f"1200{k // 2:02d}.{50 * (k % 2):02d}", n=150 * k)
    return f"${body}*{pynmea2.NMEASentence.checksum(body):02X}\r\n".encode()


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as free:
        return free.getsockname()[1]


def reports(forms):
    """Return how many TPV with a place, ATT, and ATT with a pitch gpsd makes of so many sets."""
    feed, port = socket.create_server(("127.0.0.1", 0)), free_port()
    source = f"tcp://127.0.0.1:{feed.getsockname()[1]}"
    daemon = subprocess.Popen(["root/usr/sbin/gpsd", "-N", "-n", "-S", str(port), source])

    def send():
        end, _ = feed.accept()
        time.sleep(1.0)
        for k in range(SETS):
            end.sendall(b"".join(sentence(each, k) for each in forms))
            time.sleep(0.25)
        time.sleep(1.0)
        daemon.terminate()

    sender = threading.Thread(target=send)
    sender.start()
    for _ in range(100):
        try:
            line = socket.create_connection(("127.0.0.1", port), 10.0)
            break
        except OSError:
            time.sleep(0.05)
    found = [0, 0, 0]
    with line, line.makefile("rw") as text:
        text.write('?WATCH={"enable":true,"json":true};\n')
        text.flush()
        for each in text:
            told = json.loads(each)
            found[0] += told["class"] == "TPV" and "lat" in told
            found[1] += told["class"] == "ATT"
            found[2] += told["class"] == "ATT" and "pitch" in told
    sender.join()
    return found


seen = {name: reports(forms) for name, forms in ORDERS.items()}
for name, (places, attitudes, pitches) in seen.items():
    print(f"{name}: of {SETS} sets {places} places, {attitudes} attitudes, {pitches} with pitch")
last, second, first = seen.values()
most = SETS - 4  # the first few, until it has learnt which sentence is the last
sys.exit(not (last[0] <= 4 and last[2] >= most and min(second) >= most and first[2] == 0 < first[0]))
PY
LD_LIBRARY_PATH=$(dirname "$(find "$folder/root" -name 'libgps.so*' | head -n 1)") python/bin/python seen.py
