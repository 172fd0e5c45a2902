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
exp(-kappa (x^2 - 1)), in amplitude. They have a double zero at rest, since a wave train pushes no
boat slowly. They are near in shape, and from kappa 0.25 on within 0.7 % in variance. At the surface
they are nearest in shape where a boat afloat has its own period.
"""

import math
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.noise import SEA_BANK, gaussian_pair
from trainer.core.sea.free_surface import cell

PHASE_STEP: Final = 0.25  # [rad] of the peak wave in an internal step
SLOWEST_CLOCK: Final = 0.1  # [-] least pace of the clock, where a boat is as fast as the group
MOST_STEPS: Final = 64  # internal steps in a tick; only waves above Nyquist need more
WARM_UP: Final = 600  # internal steps after which e^-12 of the slowest mode is left
STEEPEST_TURN: Final = 1.3  # [rad] of the peak wave in a tick; up to it all bands are there
RAISED_PEAKEDNESS: Final = 1.8  # [-] peakedness beyond which the peaked bank is nearer: estimate
OUTPUT_COUNT: Final = 4  # elevation, quadrature, and the force's two
COS, SIN, PUSH_COS, PUSH_SIN = range(OUTPUT_COUNT)  # their indices; the first two in a pair's rows
# [-] k_p z of the rows
FORCE_DEPTHS: Final = np.array([0.0, 0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0])


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
    2,
    4,
    2,
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
    2,
    2,
    8,
)
# By bank and depth: the force's two outputs likewise, made by tests/fits as LENGTH_TABLE is.
_FORCE_TABLE: Final = _read(
    """
    -0.2661704224730265 -1.4170152556971962 4.088220669157989 -2.3783240109910713
    -0.35536573651407416 0.5173615462726866 3.724294816887089 -6.920202153206193
    0.0913643634110981 0.4330686538001903 -2.561969680289125 3.50310124138122
    -0.015347838019338284 -0.6646512121800533 1.8727973160116742 -3.104208634383911
    -0.03917306534289773 -0.7547467347391876 1.853260459900595 -1.0484369340680595
    -0.0933415734404326 -0.3924983798247677 3.096654034449198 -4.321684079629558
    -0.02224340778347198 0.7487213577959564 -2.41533954268918 2.609315916619187
    0.060267507296632924 -0.4022546413714617 1.0065871680567693 -1.8823016711435376
    0.044481868129548956 -0.32988277502396846 0.663123088866613 -0.41323732556221904
    0.049743328650009175 -0.787314278582451 2.5211980421029674 -2.699374816103801
    -0.08275878239346154 1.1630297497854545 -2.627129859119541 1.8776758212416114
    0.17610985634384507 -0.3103293701573182 -0.006921092113930035 -0.05236468654850344
    0.09554435225970116 0.027920201184556993 -0.3001452954087933 0.1374217436360321
    0.15959050556892793 -1.0809895600074526 2.0161161427547487 -1.39550234326554
    -0.13829552342677318 1.2270766093533494 -2.32578551552622 1.2830751153596245
    0.15625149314038206 -0.09106368960151429 -0.4915738088830368 0.620101042429485
    0.09812401317951155 0.2168571536005499 -0.7356724538433564 0.392719565933418
    0.20716116125805828 -1.1734186115371372 1.7059278622007692 -0.765456884992778
    -0.16386769549654848 1.1717412764380344 -2.0120214547161765 0.9421685033955703
    0.11046999656345555 0.06296263214360819 -0.676931754246365 0.8181905260717345
    0.0843889476235927 0.34193990422854775 -0.973379071303506 0.52994047537935
    0.23349453131017955 -1.199465674905326 1.4859163565989855 -0.3966943323360708
    -0.18055267487584423 1.107655906314134 -1.7616675581863614 0.7241170382972437
    0.06514680953919966 0.18120202269313102 -0.768751470234469 0.8763088029012314
    0.03989108315374591 0.5188317576681697 -1.2224001861756424 0.662668543251975
    0.26535720402612817 -1.1953521783022985 1.1904131572388406 0.010937589371826466
    -0.2080253724805474 1.0095835601518044 -1.4034285560054571 0.4556772501843015
    -0.017124444604491876 0.37210811063010063 -0.8701855952710504 0.8723672343675721
    -0.015065066143272654 0.6673877636015454 -1.366664227072829 0.7242701930058703
    0.29132668037146997 -1.1811031187090086 0.9960012603431405 0.234880082375701
    -0.23690698530667906 0.9487926051088721 -1.1489228225243577 0.28331976315109364
    -0.09516335122605066 0.5471422444506894 -0.9478592258303139 0.8253064179106258
    -0.1571126686473873 0.99456456373263 -1.5995161658324935 0.787085145727251
    0.3537711931484094 -1.1744108784959766 0.7213719608266185 0.5061629976655618
    -0.31131968001366106 0.8896225774626001 -0.7426987553672989 0.02257821999079709
    -0.2675200195092262 0.9378019401182428 -1.1246696453919371 0.6950185230417556
    -0.37054322774282816 1.4491088022384888 -1.8563361310817184 0.8146319221585354
    0.4449741879407517 -1.1835964643978036 0.4571414435149119 0.7134736033192274
    -0.4202638496921819 0.8684378125964991 -0.311831490203231 -0.24432738379569374
    -0.498448849410194 1.4675520533241138 -1.3721812072353927 0.5080737628818106
    -1.259580429825803 3.16810972305501 -2.522066267552462 0.6696895595955453
    0.7771647094595219 -1.0748659973832537 -0.5038305134982932 1.1376283982189663
    -0.836657903259091 0.8230573048335559 1.2132519298500806 -1.1331310476393823
    -1.3648453071002413 3.4501498327030373 -2.258507916669387 -0.30312419500928756
    -0.04553492672498466 0.11850443325264667 0.003279608159455171 -0.10911225365060592
    0.046714360996313375 -0.26132541416609356 2.269412820770293 -4.330623167388017
    -0.023608909896648392 0.30242276789521333 -1.77543096990135 2.628830858817784
    -0.00906085462208639 0.1471350353954844 -0.10370466634004168 -1.8777751051452929
    -0.0007107878322313715 0.16385884738236056 -0.3111624518036505 0.1065070204356163
    0.036639272985298954 -0.2950095259491001 1.613677433961755 -2.6185963019857357
    -0.02719766620839728 0.3086268466864479 -1.4075885346799313 1.7270672121370914
    0.011795696938734113 0.17322858728381407 -0.3522296193188241 -0.7163762633023276
    0.030921109481754902 0.20477463256622078 -0.5531556762168245 0.26783923637811813
    0.03454450776847903 -0.31169512970745344 0.9323356711367105 -0.9574518047277882
    -0.023126371021037383 0.318852568704667 -1.036546229734581 0.7499630294326074
    0.02782774091669963 0.19142416250554173 -0.6732808771609343 0.7595312719081792
    0.03213045612097558 0.2237429983472973 -0.6246687130839087 0.3496452159404934
    0.04276025455369396 -0.3002038773605524 0.48765650139923566 -0.06600081300319238
    -0.04707176094604186 0.28575658354000527 -0.6694749143228657 0.27583273987543283
    0.014671322383226385 0.20581210261962005 -0.6297777862098344 0.9123726634179085
    0.022099235612169296 0.22865313919942326 -0.6054947487873195 0.35689471024446967
    0.053406255579271554 -0.28159683117432727 0.28299866862012385 0.2447101877993464
    -0.0654283465058127 0.2604459214705765 -0.46120498413202904 0.09002333354838885
    0.0005321707355488573 0.21339254393183155 -0.5564841033691621 0.8152184333930675
    0.010589321562926251 0.2312778128579931 -0.5685256456657535 0.34135962782208434
    0.06425866873398944 -0.26529875375237055 0.16644922198692294 0.3739509077146787
    -0.08018833251291786 0.2428439401581166 -0.3231561498902085 -0.004911739918113879
    -0.011516398166211974 0.22000282513093483 -0.492853155978368 0.6870344591671212
    -0.01207080098560168 0.23720050229944084 -0.4889521876866363 0.2902372106908094
    0.08589564732772993 -0.2405916129313355 0.03704175656426713 0.44633190518120813
    -0.10417687139722066 0.22013008262583716 -0.1385507697452382 -0.099131143780024
    -0.03126536731711676 0.2329504363757366 -0.39218223747743786 0.4399827160991578
    -0.03434913682492818 0.24606668851883456 -0.41237352770081476 0.2304287954044151
    0.10834267382877268 -0.22281815033415425 -0.03722581607472945 0.42873479397308406
    -0.12512240374118344 0.20619573801300597 -0.006873315512725383 -0.14625972515862
    -0.04811224158072859 0.24693635100780956 -0.31273856661913035 0.2159367637964184
    -0.08306753533214759 0.2742698940866428 -0.25758416587060995 0.09206853830035128
    0.16077060371861115 -0.19706503282325055 -0.13495581159122616 0.29592113657929286
    -0.16807732060817748 0.19161897427990734 0.20980118857147764 -0.20001206797913962
    -0.08078837865347237 0.2827340269633249 -0.1793062448532561 -0.21366548413004638
    -0.1462496873941663 0.31956803920106747 -0.07133947756091918 -0.08993452206025711
    0.23211266179898427 -0.1752078632721844 -0.21983028319643552 0.07074615409633216
    -0.22319073115370053 0.18812213683128734 0.43873589920968686 -0.2440316335364283
    -0.12011009479927054 0.33676923973090367 -0.045272467659010225 -0.7059108252586923
    -0.3752206760527898 0.49658127291188686 0.5857202657084531 -0.7637758357594192
    0.4966993683571226 -0.11329263155132227 -0.45400134961833316 -0.8443532749140948
    -0.4282477956210453 0.20705917367133556 1.195544847968176 -0.37577343721526674
    -0.25941623369830036 0.5548245276461269 0.3700684014135995 -2.3910261779065665
    """,
    2,
    11,
    2,
    8,
)
# As the kernels read them: factors by part and mode, rows by mode and output.
REAL, IMAGINARY = 0, 1  # rows of a bank's modes
MODE_FACTORS: Final = np.ascontiguousarray(np.swapaxes(_MODE_FACTORS, 1, 2))
WAVE_ROWS: Final = np.ascontiguousarray(np.swapaxes(_WAVE_TABLE, 1, 2))
FORCE_ROWS: Final = np.ascontiguousarray(np.swapaxes(_FORCE_TABLE, 2, 3))
# By bank and depth: the wave number of the waves left there over the peak's, the integral of
# x^6 S exp(-2 kappa x^2) over that of x^4. It is taken for all waves: estimate. At the
# surface it is cut at x = 3.5, as the row is.
FLAT, PEAKED = 0, 1  # banks
LENGTH_TABLE: Final = _read(
    """
    4.914292250681751 3.724495428468583 2.308548658766213 1.666898842053118
    1.3953208571480866 1.2359446291044036 1.048005367470525 0.9357224605626057
    0.8011155124088732 0.7194349713632331 0.6201648833867759
    4.539844812315816 3.2973332389174654 2.0010998211732582 1.4594690053837174
    1.2564199924191952 1.148785236549667 1.031933262366336 0.96248019556175
    0.864749558754242 0.7849129266100554 0.6571063718318576
    """,
    2,
    11,
)


@inline_kernel
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


@inline_kernel
def choose_rows(bank: int, row: int, inside: float, scratch: Record) -> None:
    """Write a bank's rows [-] of the force for a depth between two of FORCE_DEPTHS."""
    work = scratch[0]
    for i in range(8):
        for j in range(2):
            upper, lower = FORCE_ROWS[bank, row, i, j], FORCE_ROWS[bank, row + 1, i, j]
            work.force_rows[bank, i, j] = upper + inside * (lower - upper)


@inline_kernel
def add_outputs(bank: int, size: float, row: int, scratch: Record, state: Record) -> None:
    """Add ``size`` times the outputs of a bank to the history.

    ``row`` is theirs in it. Sums in registers cost half of those in the record.
    """
    s, work = state[0], scratch[0]
    wave_cos, wave_sin = s.sea_past[row, COS], s.sea_past[row, SIN]
    push_cos, push_sin = s.sea_past[row, PUSH_COS], s.sea_past[row, PUSH_SIN]
    for i in range(8):
        x = size * s.sea_modes[bank, i]
        wave_cos += WAVE_ROWS[bank, i, COS] * x
        wave_sin += WAVE_ROWS[bank, i, SIN] * x
        push_cos += work.force_rows[bank, i, COS] * x
        push_sin += work.force_rows[bank, i, SIN] * x
    s.sea_past[row, COS], s.sea_past[row, SIN] = wave_cos, wave_sin
    s.sea_past[row, PUSH_COS], s.sea_past[row, PUSH_SIN] = push_cos, push_sin


@inline_kernel
def note_outputs(step: int, scratch: Record, state: Record) -> None:
    """Write the outputs [-] of both banks over the oldest ones.

    Each bank counts by its share.
    """
    s = state[0]
    row = step & 3
    for j in range(OUTPUT_COUNT):
        s.sea_past[row, j] = 0.0
    if s.sea_peaked < 1.0:
        add_outputs(0, math.sqrt(1.0 - s.sea_peaked), row, scratch, state)
    if s.sea_peaked > 0.0:
        add_outputs(1, math.sqrt(s.sea_peaked), row, scratch, state)


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


@inline_kernel
def left_length(row: int, inside: float, peaked: float) -> float:
    """Return the wave number of the waves left at a depth, over the peak's [-]."""
    flat = LENGTH_TABLE[FLAT, row] + inside * (
        LENGTH_TABLE[FLAT, row + 1] - LENGTH_TABLE[FLAT, row]
    )
    raised = LENGTH_TABLE[PEAKED, row] + inside * (
        LENGTH_TABLE[PEAKED, row + 1] - LENGTH_TABLE[PEAKED, row]
    )
    return flat + peaked * (raised - flat)


@inline_kernel
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


@inline_kernel
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
