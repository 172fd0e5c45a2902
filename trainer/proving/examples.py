"""Small files of each kind, for a fuzzer to begin with."""

from typing import Final

CONDITIONS: Final = (
    "depth > 100",
    "speed < 4 kn",
    "pitch >= -1.5e1 deg",
    "flood_aft > 20 t",
    "bank_main<= 9 mpa",
)
STUDY: Final = b"""schema = "identify/1"
name = "A zig-zag"
data = "proof.csv"
from_s = 1.0

[ship]
length_m = 100.0

[model]
name = "nomoto-1"

[[columns]]
channel = "heading"
name = "psi"
unit = "deg"

[[parameters]]
name = "K"
value = 0.1
"""
NOMOTO: Final = b"""schema = "nomoto/1"
name = "A ship"
speed_m_s = 8.0
K_1_s = 0.05
T_s = 20.0
rudder_limit_deg = 35
rudder_rate_deg_s = 3
step_s = 0.5
"""
DECCA: Final = b"""schema = "decca/1"
name = "A turn"
data = "proof.csv"
start_east_m = 1000
start_north_m = 2000

[[slaves]]
colour = "red"
east_m = 50000
north_m = 0
lane_m = 420.5

[[slaves]]
colour = "green"
east_m = 0
north_m = 60000
frequency_khz = 255

[columns]
t_s = "t"
yaw_rate_deg_s = "r"
"""
READINGS: Final = (
    b"t,rudder,heading,red,green,purple\n0,0,1,A12.5,B30.25,\n1,5,2.5,A12.75,B30.5,C51\n"
)
STATE: Final = (
    b'{"u": 5, "v": 0, "w": 0, "p": 0, "q": 0, "r": 0, "phi": 0, "theta": 0, "psi": 0, '
    b'"delta_r": 0.1, "delta_s": 0, "delta_b": 0, "u_c": 5, "last_udot": 0, "weight": 4e7}\n'
)
GUIDE: Final = (
    b'{"vessel": "bb2", "sheets": [{"title": "Turn", "judgements": {"modified": [{"quantity": "d",'
    b' "unit": "m", "full": 1.0, "other": 1.1, "verdict": "passed"}]}}], "findings": [{"title": "a"'
    b', "verdict": "b"}], "steps": []}'
)
CHECKPOINT: Final = b'{"model": "nomoto", "cost": 1.5, "parameters": {"K": 0.1, "T": 20.0}}'
BOAT: Final = """schema = "gertler-hagen-2510/1"
[fluid]
rho = 1025
g = 9.81
[vessel]
length = 5.3
mass = 5443.4
weight = 53400
buoyancy = 53400
cg = [0, 0, 0.061]
cb = [0, 0, 0]
Ix = 2038
Iy = 13587
Iz = 13587
[[propulsion.sets]]
eta_min = 0
a = -0.004
b = 0
c = 0.004
[[propulsion.sets]]
eta_min = -99
a = -0.004
b = 0
c = -0.004
[coefficients]
"""
