"""Long-crested waves as filtered noise whose energy is right in every band.

Four modes, pairs of poles in units of the peak frequency, are driven by one white noise at a fixed
step of the peak wave's phase. So no number here depends on sea, boat or tick. Impulse invariance is
exact in the poles and stable at any tick, and the outputs are interpolated to the ticks. There are
two banks of modes. One is for the spectra of Pierson-Moskowitz and Bretschneider, the other for
JONSWAP with the peak raised 3.3 times. They are fitted by this project: in bands of a tenth of the
peak frequency from 0.6 to 2 the energy is within 4 % of the spectrum's.

A boat that runs with the waves meets a component of x times the peak's frequency at x - nu x^2
times it, nu = k_p U/omega_p. The clock of the bank gives the slope of that at the peak, 1 - 2 nu.
Turning the pair of outputs by k_p times the way gives its value there, 1 - nu.

The effect of waves at a depth differs from that at the surface: each component fades by its own
length. The force's pair has rows of its own by kappa = k_p z: the surface's pair times x^2
exp(-kappa (x^2 - 1)), in amplitude. They are near in shape and exact in variance.
"""

import math
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers, Record, kernel, part
from trainer.core.noise import SEA_BANK, gaussian_pair
from trainer.core.sea.free_surface import cell

PHASE_STEP: Final = 0.25  # [rad] of the peak wave in an internal step
SLOWEST_CLOCK: Final = 0.1  # [-] least pace of the clock, where a boat is as fast as the group
MOST_STEPS: Final = 64  # internal steps in a tick; only waves above Nyquist need more
WARM_UP: Final = 600  # internal steps after which e^-12 of the slowest mode is left
STEEPEST_TURN: Final = 1.3  # [rad] of the peak wave in a tick; up to it all bands are there
RAISED_PEAKEDNESS: Final = 1.8  # [-] peakedness beyond which the peaked bank is nearer: estimate
OUTPUT_COUNT: Final = 4  # elevation, quadrature, and the force's two
# [-] k_p z of the rows
FORCE_DEPTHS: Final = np.array([0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0])


def _read(text: str, *shape: int) -> Numbers:
    """Return the numbers in a text."""
    return np.fromstring(text, sep=" ").reshape(shape)


# By bank and mode: real and imaginary part [-] of its factor in an internal step.
_MODE_FACTORS: Final = _read(
    """
    0.9576797801870172 0.1614433270613848 0.9315621309263741 0.19185290956293574
    0.8773545393173064 0.2302827579341405 0.7369715944272253 0.2698603850321235
    0.9642115579686314 0.17317765829384052 0.9483327815430371 0.23870650666379953
    0.8161882600058278 0.30597466349472224 0.5555107844325968 0.3062302428382245
    """,
    *(2, 4, 2),
)
# By bank: elevation and quadrature [-] over the modes, their real parts first.
_WAVE_TABLE: Final = _read(
    """
    0.0006647961160219201 0.10347175449175428 -0.16379391732115162 0.059657366713375494
    0.14981234046552838 -0.9273275469142623 1.8634106126349745 -1.5015004552645812
    -0.1198269708129039 0.9776556562550038 -2.0738003344111964 1.3344445410036387
    0.015522059016629728 0.004121739491565363 -0.2715628680721062 0.38021074492046525
    -0.004126846818164652 0.22086132541957204 -0.461984988928287 0.24525051032687947
    0.0706791963540821 -0.267681303848375 0.5392154900046601 -0.47273318996531977
    -0.0709622052166824 0.2671491076160079 -0.5639791649032333 0.40412863331115884
    -0.005799023462305099 0.21877338890709153 -0.479869078695576 0.3672596301850057
    """,
    *(2, 2, 8),
)
# By bank and depth: the force's two outputs likewise.
_FORCE_TABLE: Final = _read(
    """
    0.05622968671549084 -0.34607283957225765 0.6199792156689244 -0.37969207882918377
    0.04463675004030059 -0.8189734340877829 2.5558002094842553 -2.6630109381216047
    0.04386025599789406 0.9196575214987043 -3.1180166893853016 2.3682347381945354
    0.08755579467398646 -0.6280992200678143 0.41872471395458666 0.38255368439256593
    0.12734363680915214 -0.11418612835345118 -0.4262966038878488 0.36639381150821215
    0.1071648777506113 -1.161446527978975 2.243524024537068 -1.2780462834710602
    -0.03295929685136781 1.0295769793431087 -2.683500121869553 1.632270044056087
    0.08831496502910664 -0.3458943549099292 -0.16884011697280896 0.9539688968174158
    0.12795198873996166 0.05800405174731445 -0.8540000505698139 0.6395833104286923
    0.14790816797069523 -1.2457380632669703 1.9510240517167659 -0.6504993936243023
    -0.09922807116120928 1.054123569902355 -2.21943598468948 1.1415206475855906
    0.07135591745824237 -0.09153003743451152 -0.4878193284854542 1.01012402943339
    0.10848785119275424 0.19583796197178557 -1.0677050444472052 0.7502750864707032
    0.17877119924724333 -1.255685114628218 1.7067515711631098 -0.3026425579191726
    -0.15254066121541146 1.0613307617518395 -1.8462065526840763 0.8005985956523863
    0.05033789434746301 0.11525358707766564 -0.6947569395545801 0.9513374883898601
    0.05184446145173079 0.4214824055681105 -1.267575267406995 0.8017126372084574
    0.22879175075103578 -1.220933132784163 1.333864011560843 0.05807711883200064
    -0.236884989715229 1.0684566914816904 -1.2937465931019072 0.3434317714431013
    0.0038993019513574776 0.44440576877760596 -0.9697377854180814 0.7686737403722753
    -0.014382748732016453 0.6253844718856332 -1.3676206724901943 0.7766406489321707
    0.275386313895111 -1.1792533713212041 1.0536409455805869 0.23951254198703412
    -0.3073323987875196 1.0786577519689788 -0.885136768716772 0.029117658220021676
    -0.04787235338659836 0.7211391271581004 -1.1697803563247464 0.5836506121389828
    -0.17828755138640015 1.0692724927754889 -1.5099098879505226 0.654020314274964
    0.3811030642630993 -1.11500872674497 0.5906734065468248 0.4282681685808283
    -0.44201911283602635 1.1166858166235034 -0.23888056935592386 -0.4427275766513158
    -0.17735748111194624 1.2557350008557413 -1.516738152270395 0.23754915877739766
    -0.41589188440931585 1.6616105086168356 -1.6516685754230063 0.4509853051780432
    0.523790627116139 -1.0510434290212158 0.0922150245925951 0.5352597993949036
    -0.6004718582087387 1.1757058736004302 0.38384584151056383 -0.8758141405488254
    -0.368388767436061 1.8970027367808577 -1.8976921132859865 -0.12575840301326882
    -1.380618311823667 3.8417024355563965 -1.9076309905832232 -0.4919583379541815
    1.032056288419162 -0.6882079947195008 -1.6689688822517275 0.6010870031639792
    -1.1142929216344664 1.263901087938944 2.237872651543166 -2.0176294042503105
    -1.17062202946829 4.0917865014986985 -2.993994798601427 -1.237992471157753
    0.015100776099923165 0.18856885762962697 -0.6718636456035136 0.41576699704586506
    0.022431393397080515 -0.31747012578169476 0.9779414811270648 -0.7347974980254645
    -0.03185051959306566 0.3033710017524883 -1.1859715653574474 0.836258308167875
    0.00020532526194614955 0.17413445057896915 -0.6874112833143413 1.0954411568790194
    0.017437652302718987 0.20855875655008835 -0.7196334924416139 0.48355419306074326
    0.03379101640852903 -0.30250966390946854 0.5329144930999409 0.10624338722007587
    -0.04636848121851487 0.2856953362431998 -0.6676168912095147 0.27030295420147027
    0.012991795109579178 0.20485921082505712 -0.6320365102212533 0.8979166281522469
    0.013929241039728153 0.22041193797024075 -0.6513299516209219 0.4305715469367642
    0.049790264017985475 -0.2816551094854081 0.31139551232289747 0.3222228288442899
    -0.05951471643498769 0.27112389447098223 -0.36485785442423146 0.03026005824215057
    0.016581628140399384 0.22437738471508212 -0.5507398160262864 0.5866366830459511
    0.008561358858931034 0.22944519344049222 -0.5717667682272786 0.35870135810547354
    0.06495074526555726 -0.2638442665043679 0.17693230775433222 0.3725373350618998
    -0.07116101223608144 0.25898976168722787 -0.16877343582256063 -0.09637197045346625
    0.01537337823726626 0.23761372754918217 -0.47964171087766233 0.3297982888192266
    -0.004627712333165754 0.24463403008081427 -0.42901777171268873 0.22023568017004558
    0.09230707991434613 -0.23690068542450854 0.017613235086747493 0.3322350118245881
    -0.09194589227905378 0.23939491814773234 0.06670250564129296 -0.21537128902194008
    0.0056919855325751785 0.25490842282965614 -0.36864520423995517 -0.029051927774994237
    -0.020186516799258217 0.2593483638453241 -0.30966138367572044 0.09904697295435624
    0.11801356892878083 -0.21748726963135256 -0.07855771658056693 0.2407297906712357
    -0.11212332519062634 0.22448187115973137 0.20082327013937695 -0.2605446729961692
    -0.00943351084437354 0.2680341611181151 -0.2856371807328371 -0.25730921466388373
    -0.06011685299507788 0.29411710272204167 -0.1050099799926031 -0.11516689698513324
    0.17327779997222514 -0.19004834262044984 -0.20448511221668644 0.024072291210003628
    -0.15911647603870083 0.20344039782585582 0.34829837893092347 -0.27083959134804736
    -0.05264214532792355 0.29680868224870227 -0.1577111796473233 -0.526701316937711
    -0.11888379588170409 0.34255984067259865 0.09991368163835788 -0.33155401668110956
    0.24507577621690227 -0.16842960862901737 -0.30408121165565805 -0.23005760443594392
    -0.2256063193366806 0.1866589950967685 0.4268447793851782 -0.2237795136067977
    -0.11930043459402967 0.3375546418584465 -0.03757009170003389 -0.6730865920824058
    -0.35720099411104034 0.5121736193292807 0.688324529898799 -0.922892064140714
    0.5036521010455434 -0.11104499265549189 -0.5152759706878858 -1.01497659873556
    -0.48037896989761675 0.12883890921992186 0.4214516660548855 0.10921228218498985
    -0.39521421435866166 0.4748374116188948 0.31852160782843497 -0.6335844452834463
    """,
    *(2, 9, 2, 8),
)
# As the kernels read them: factors by part and mode, rows by mode and output.
REAL, IMAGINARY = 0, 1  # rows of a bank's modes
MODE_FACTORS: Final = np.ascontiguousarray(np.swapaxes(_MODE_FACTORS, 1, 2))
WAVE_ROWS: Final = np.ascontiguousarray(np.swapaxes(_WAVE_TABLE, 1, 2))
FORCE_ROWS: Final = np.ascontiguousarray(np.swapaxes(_FORCE_TABLE, 2, 3))
# By bank and depth: the wave number of the waves left there over the peak's, the integral of
# x^6 S exp(-2 kappa x^2) over that of x^4. It is taken for all waves: estimate.
FLAT, PEAKED = 0, 1  # banks
LENGTH_TABLE: Final = np.array(
    [
        [2.3085, 1.6669, 1.3953, 1.2359, 1.0480, 0.9357, 0.8011, 0.7194, 0.6202],
        [2.0011, 1.4595, 1.2564, 1.1488, 1.0319, 0.9625, 0.8647, 0.7849, 0.6571],
    ]
)


@part
def advance_modes(bank: int, step: int, state: Record) -> None:
    """Advance one bank by the internal step of that number.

    An odd step takes the deviate that the step before it left over.
    """
    s = state[0]
    x = s.sea_spare[bank]
    if step & 1 == 0:
        x, s.sea_spare[bank] = gaussian_pair(int(s.seed), SEA_BANK + bank, step >> 1)
    for i in range(4):
        along, across = MODE_FACTORS[bank, REAL, i], MODE_FACTORS[bank, IMAGINARY, i]
        a, b = s.sea_modes[bank, i], s.sea_modes[bank, 4 + i]
        s.sea_modes[bank, i] = along * a - across * b + x
        s.sea_modes[bank, 4 + i] = across * a + along * b


@part
def choose_rows(bank: int, row: int, inside: float, scratch: Record) -> None:
    """Write a bank's rows [-] of the force for a depth between two of FORCE_DEPTHS."""
    work = scratch[0]
    for i in range(8):
        for j in range(2):
            upper, lower = FORCE_ROWS[bank, row, i, j], FORCE_ROWS[bank, row + 1, i, j]
            work.force_rows[bank, i, j] = upper + inside * (lower - upper)


@part
def add_outputs(bank: int, size: float, place: int, scratch: Record, state: Record) -> None:
    """Add ``size`` times the outputs of a bank to the history.

    ``place`` is their place in it.
    """
    s, work = state[0], scratch[0]
    for i in range(8):
        x = size * s.sea_modes[bank, i]
        for j in range(2):
            s.sea_past[place, j] += WAVE_ROWS[bank, i, j] * x
            s.sea_past[place, 2 + j] += work.force_rows[bank, i, j] * x


@part
def note_outputs(step: int, scratch: Record, state: Record) -> None:
    """Write the outputs [-] of both banks over the oldest ones.

    Each bank counts by its share.
    """
    s = state[0]
    place = step & 3
    for j in range(OUTPUT_COUNT):
        s.sea_past[place, j] = 0.0
    if s.sea_peaked < 1.0:
        add_outputs(0, math.sqrt(1.0 - s.sea_peaked), place, scratch, state)
    if s.sea_peaked > 0.0:
        add_outputs(1, math.sqrt(s.sea_peaked), place, scratch, state)


@kernel
def begin_filter(kappa: float, scratch: Record, state: Record) -> None:
    """Start both banks at random, as if they had always run.

    ``kappa`` is the peak wave's number times the depth [-].
    """
    s = state[0]
    row, inside = cell(FORCE_DEPTHS, FORCE_DEPTHS.size, kappa)
    s.sea_clock = 0.0
    for bank in range(2):
        for i in range(8):
            s.sea_modes[bank, i] = 0.0
        s.sea_spare[bank] = 0.0
        choose_rows(bank, row, inside, scratch)
    for step in range(int(s.sea_steps) - WARM_UP, int(s.sea_steps)):
        for bank in range(2):
            advance_modes(bank, step, state)
        note_outputs(step, scratch, state)


@part
def left_length(row: int, inside: float, peaked: float) -> float:
    """Return the wave number of the waves left at a depth, over the peak's [-]."""
    flat = LENGTH_TABLE[FLAT, row] + inside * (
        LENGTH_TABLE[FLAT, row + 1] - LENGTH_TABLE[FLAT, row]
    )
    raised = LENGTH_TABLE[PEAKED, row] + inside * (
        LENGTH_TABLE[PEAKED, row + 1] - LENGTH_TABLE[PEAKED, row]
    )
    return flat + peaked * (raised - flat)


@part
def advance_clock(number: float, run: float, h: float, scratch: Record, state: Record) -> None:
    """Advance the banks by the internal steps of a tick of ``h`` [s].

    ``number`` [1/m] is that of the peak wave, ``run`` [m] the boat's way with the waves.
    """
    s = state[0]
    row, inside = cell(FORCE_DEPTHS, FORCE_DEPTHS.size, number * max(s.z, 0.0))
    s.push_number = number * left_length(row, inside, s.sea_peaked)
    if s.sea_peaked < 1.0:
        choose_rows(0, row, inside, scratch)
    if s.sea_peaked > 0.0:
        choose_rows(1, row, inside, scratch)
    turn = s.sea_omega * h
    s.sea_clock += max(turn - 2.0 * number * run, SLOWEST_CLOCK * turn) / PHASE_STEP
    done = 0
    while s.sea_clock >= 1.0 and done < MOST_STEPS:
        step = int(s.sea_steps)
        if s.sea_peaked < 1.0:
            advance_modes(0, step, state)
        if s.sea_peaked > 0.0:
            advance_modes(1, step, state)
        note_outputs(step, scratch, state)
        s.sea_steps += 1.0
        s.sea_clock -= 1.0
        done += 1
    s.sea_clock -= math.floor(s.sea_clock)


@part
def read_outputs(turn_cos: float, turn_sin: float, state: Record) -> None:
    """Write the waves above the boat from the last outputs.

    They are turned by the boat's way. Lagrange's cubic goes through four outputs, with the clock
    between the middle two.
    """
    s = state[0]
    f = s.sea_clock
    before, after, beyond = f + 1.0, f - 1.0, f - 2.0
    w0 = -f * after * beyond * 0.16666666666666666
    w1 = before * after * beyond * 0.5
    w2 = -before * f * beyond * 0.5
    w3 = before * f * after * 0.16666666666666666
    oldest = int(s.sea_steps)
    i0, i1, i2, i3 = oldest & 3, (oldest + 1) & 3, (oldest + 2) & 3, (oldest + 3) & 3
    for j in range(OUTPUT_COUNT):
        early = w0 * s.sea_past[i0, j] + w1 * s.sea_past[i1, j]
        s.sea_waves[j] = early + (w2 * s.sea_past[i2, j] + w3 * s.sea_past[i3, j])
    for j in range(0, OUTPUT_COUNT, 2):
        cosine_part, sine_part = s.sea_waves[j], s.sea_waves[j + 1]
        s.sea_waves[j] = cosine_part * turn_cos - sine_part * turn_sin
        s.sea_waves[j + 1] = sine_part * turn_cos + cosine_part * turn_sin
