"""The 131 terms of NSRDC Report 2510 [GH67], and those of the compact set.

Readers of vessel files, records, the report's programs and the pages take their coefficients from
this one table. A compact set keeps only some of them.

V is (v^2 + w^2)^1/2. Where the scan of [ASSES] misleads: the L^3 beside Z_star, Z_w, Z_waw and
beside the Z eta terms is L^2; IQQ, XW, KWE, KDRDRE, KDSDSE, KXQ, KVR and the pitch equation's MW in
its Table 19 are XQQ, XWW, XWWE, XDRDRE, XDSDSE, XWQ, XVR and MWW.
"""

from typing import Final, NamedTuple


class Term(NamedTuple):
    """A term: coefficient, equation, power of L [-], its factors, and its name of 1969."""

    key: str
    equation: str
    power: int
    multiplies: str
    mnemonic: str

    @property
    def kept(self) -> bool:
        """Return whether every compact set keeps it."""
        return self.key in COMPACT_TERMS or self.key in THRUST_KEYS


TERM_TABLE: Final = (  # in the order of the equations
    # axial force
    Term("X_qq", "X", 4, "q^2", "XQQ"),
    Term("X_rr", "X", 4, "r^2", "XRR"),
    Term("X_rp", "X", 4, "r p", "XRP"),
    Term("X_udot", "X", 3, "udot", "XUD"),
    Term("X_vr", "X", 3, "v r", "XVR"),
    Term("X_wq", "X", 3, "w q", "XWQ"),
    Term("X_uu", "X", 2, "u^2", "XUU"),
    Term("X_vv", "X", 2, "v^2", "XVV"),
    Term("X_ww", "X", 2, "w^2", "XWW"),
    Term("X_drdr", "X", 2, "u^2 dr^2", "XDRDR"),
    Term("X_dsds", "X", 2, "u^2 ds^2", "XDSDS"),
    Term("X_dbdb", "X", 2, "u^2 db^2", "XDBDB"),
    Term("X_vv_eta", "X", 2, "v^2 (eta-1)", "XVVE"),
    Term("X_ww_eta", "X", 2, "w^2 (eta-1)", "XWWE"),
    Term("X_drdr_eta", "X", 2, "u^2 dr^2 (eta-1)", "XDRDRE"),
    Term("X_dsds_eta", "X", 2, "u^2 ds^2 (eta-1)", "XDSDSE"),
    Term("a1", "X", 2, "u^2", "A11"),
    Term("b1", "X", 2, "u uc", "A12"),
    Term("c1", "X", 2, "uc^2", "A13"),
    Term("a2", "X", 2, "u^2", "A21"),
    Term("b2", "X", 2, "u uc", "A22"),
    Term("c2", "X", 2, "uc^2", "A23"),
    Term("a3", "X", 2, "u^2", "A31"),
    Term("b3", "X", 2, "u uc", "A32"),
    Term("c3", "X", 2, "uc^2", "A33"),
    # lateral force
    Term("Y_rdot", "Y", 4, "rdot", "YRD"),
    Term("Y_pdot", "Y", 4, "pdot", "YPD"),
    Term("Y_pap", "Y", 4, "p |p|", "YPAP"),
    Term("Y_pq", "Y", 4, "p q", "YPQ"),
    Term("Y_qr", "Y", 4, "q r", "YQR"),
    Term("Y_vdot", "Y", 3, "vdot", "YVD"),
    Term("Y_vq", "Y", 3, "v q", "YVQ"),
    Term("Y_wp", "Y", 3, "w p", "YWP"),
    Term("Y_wr", "Y", 3, "w r", "YWR"),
    Term("Y_r", "Y", 3, "u r", "YR"),
    Term("Y_p", "Y", 3, "u p", "YP"),
    Term("Y_ardr", "Y", 3, "u |r| dr", "YARDR"),
    Term("Y_var", "Y", 3, "sgn(v) (v^2+w^2)^0.5 |r|", "YVAR"),
    Term("Y_star", "Y", 2, "u^2", "YSTR"),
    Term("Y_v", "Y", 2, "u v", "YV"),
    Term("Y_vav", "Y", 2, "v (v^2+w^2)^0.5", "YVAV"),
    Term("Y_vw", "Y", 2, "v w", "YVW"),
    Term("Y_dr", "Y", 2, "u^2 dr", "YDR"),
    Term("Y_r_eta", "Y", 3, "u r (eta-1)", "YRE"),
    Term("Y_v_eta", "Y", 2, "u v (eta-1)", "YVE"),
    Term("Y_vav_eta", "Y", 2, "v (v^2+w^2)^0.5 (eta-1)", "YVAVE"),
    Term("Y_dr_eta", "Y", 2, "u^2 dr (eta-1)", "YDRE"),
    # normal force
    Term("Z_qdot", "Z", 4, "qdot", "ZQD"),
    Term("Z_pp", "Z", 4, "p^2", "ZPP"),
    Term("Z_rr", "Z", 4, "r^2", "ZRR"),
    Term("Z_rp", "Z", 4, "r p", "ZRP"),
    Term("Z_wdot", "Z", 3, "wdot", "ZWD"),
    Term("Z_vr", "Z", 3, "v r", "ZVR"),
    Term("Z_vp", "Z", 3, "v p", "ZVP"),
    Term("Z_q", "Z", 3, "u q", "ZQ"),
    Term("Z_aqds", "Z", 3, "u |q| ds", "ZAQDS"),
    Term("Z_waq", "Z", 3, "sgn(w) (v^2+w^2)^0.5 |q|", "ZWAQ"),
    Term("Z_star", "Z", 2, "u^2", "ZSTR"),
    Term("Z_w", "Z", 2, "u w", "ZW"),
    Term("Z_waw", "Z", 2, "w (v^2+w^2)^0.5", "ZWAW"),
    Term("Z_aw", "Z", 2, "u |w|", "ZAW"),
    Term("Z_ww", "Z", 2, "|w (v^2+w^2)^0.5|", "ZWW"),
    Term("Z_vv", "Z", 2, "v^2", "ZVV"),
    Term("Z_ds", "Z", 2, "u^2 ds", "ZDS"),
    Term("Z_db", "Z", 2, "u^2 db", "ZDB"),
    Term("Z_q_eta", "Z", 3, "u q (eta-1)", "ZQE"),
    Term("Z_w_eta", "Z", 2, "u w (eta-1)", "ZWE"),
    Term("Z_waw_eta", "Z", 2, "w (v^2+w^2)^0.5 (eta-1)", "ZWAWE"),
    Term("Z_ds_eta", "Z", 2, "u^2 ds (eta-1)", "ZDSE"),
    # rolling moment
    Term("K_pdot", "K", 5, "pdot", "KPD"),
    Term("K_rdot", "K", 5, "rdot", "KRD"),
    Term("K_qr", "K", 5, "q r", "KQR"),
    Term("K_pq", "K", 5, "p q", "KPQ"),
    Term("K_pap", "K", 5, "p |p|", "KPAP"),
    Term("K_p", "K", 4, "u p", "KP"),
    Term("K_r", "K", 4, "u r", "KR"),
    Term("K_vdot", "K", 4, "vdot", "KVD"),
    Term("K_vq", "K", 4, "v q", "KVQ"),
    Term("K_wp", "K", 4, "w p", "KWP"),
    Term("K_wr", "K", 4, "w r", "KWR"),
    Term("K_star", "K", 3, "u^2", "KSTR"),
    Term("K_v", "K", 3, "u v", "KV"),
    Term("K_vav", "K", 3, "v (v^2+w^2)^0.5", "KVAV"),
    Term("K_vw", "K", 3, "v w", "KVW"),
    Term("K_dr", "K", 3, "u^2 dr", "KDR"),
    Term("K_star_eta", "K", 3, "u^2 (eta-1)", "KSTRE"),
    # pitching moment
    Term("M_qdot", "M", 5, "qdot", "MQD"),
    Term("M_pp", "M", 5, "p^2", "MPP"),
    Term("M_rr", "M", 5, "r^2", "MRR"),
    Term("M_rp", "M", 5, "r p", "MRP"),
    Term("M_qaq", "M", 5, "q |q|", "MQAQ"),
    Term("M_wdot", "M", 4, "wdot", "MWD"),
    Term("M_vr", "M", 4, "v r", "MVR"),
    Term("M_vp", "M", 4, "v p", "MVP"),
    Term("M_q", "M", 4, "u q", "MQ"),
    Term("M_aqds", "M", 4, "u |q| ds", "MAQDS"),
    Term("M_awq", "M", 4, "(v^2+w^2)^0.5 q", "MAWQ"),
    Term("M_star", "M", 3, "u^2", "MSTR"),
    Term("M_w", "M", 3, "u w", "MW"),
    Term("M_waw", "M", 3, "w (v^2+w^2)^0.5", "MWAW"),
    Term("M_aw", "M", 3, "u |w|", "MAW"),
    Term("M_ww", "M", 3, "|w (v^2+w^2)^0.5|", "MWW"),
    Term("M_vv", "M", 3, "v^2", "MVV"),
    Term("M_ds", "M", 3, "u^2 ds", "MDS"),
    Term("M_db", "M", 3, "u^2 db", "MDB"),
    Term("M_q_eta", "M", 4, "u q (eta-1)", "MQE"),
    Term("M_w_eta", "M", 3, "u w (eta-1)", "MWE"),
    Term("M_waw_eta", "M", 3, "w (v^2+w^2)^0.5 (eta-1)", "MWAWE"),
    Term("M_ds_eta", "M", 3, "u^2 ds (eta-1)", "MDSE"),
    # yawing moment
    Term("N_rdot", "N", 5, "rdot", "NRD"),
    Term("N_pdot", "N", 5, "pdot", "NPD"),
    Term("N_pq", "N", 5, "p q", "NPQ"),
    Term("N_qr", "N", 5, "q r", "NQR"),
    Term("N_rar", "N", 5, "r |r|", "NRAR"),
    Term("N_vdot", "N", 4, "vdot", "NVD"),
    Term("N_wr", "N", 4, "w r", "NWR"),
    Term("N_wp", "N", 4, "w p", "NWP"),
    Term("N_vq", "N", 4, "v q", "NVQ"),
    Term("N_p", "N", 4, "u p", "NP"),
    Term("N_r", "N", 4, "u r", "NR"),
    Term("N_ardr", "N", 4, "u |r| dr", "NARDR"),
    Term("N_avr", "N", 4, "(v^2+w^2)^0.5 r", "NAVR"),
    Term("N_star", "N", 3, "u^2", "NSTR"),
    Term("N_v", "N", 3, "u v", "NV"),
    Term("N_vav", "N", 3, "v (v^2+w^2)^0.5", "NVAV"),
    Term("N_vw", "N", 3, "v w", "NVW"),
    Term("N_dr", "N", 3, "u^2 dr", "NDR"),
    Term("N_r_eta", "N", 4, "u r (eta-1)", "NRE"),
    Term("N_v_eta", "N", 3, "u v (eta-1)", "NVE"),
    Term("N_vav_eta", "N", 3, "v (v^2+w^2)^0.5 (eta-1)", "NVAVE"),
    Term("N_dr_eta", "N", 3, "u^2 dr (eta-1)", "NDRE"),
)
THRUST_KEYS: Final = tuple(
    term.key for term in TERM_TABLE if not term.key.startswith(f"{term.equation}_")
)
COEFFICIENTS: Final = tuple(term for term in TERM_TABLE if term.key not in THRUST_KEYS)
LENGTH_POWERS: Final = {term.key: term.power for term in COEFFICIENTS}  # of the length

# The compact set keeps these and the thrust rows, [ASSES] Table 18 with errata C18, C19.
# fmt: off
COMPACT_TERMS: Final = (
    "X_udot", "X_drdr", "X_dsds", "X_dbdb",
    "Y_pdot", "Y_rdot", "Y_vdot", "Y_r", "Y_p", "Y_v", "Y_vav", "Y_dr",
    "Z_qdot", "Z_wdot", "Z_q", "Z_w", "Z_star", "Z_ds", "Z_db", "Z_waw", "Z_vv", "Z_rr", "Z_vr",
    "K_rdot", "K_pdot", "K_vdot", "K_p", "K_v", "K_vav",
    "M_qdot", "M_wdot", "M_q", "M_w", "M_star", "M_awq", "M_waw", "M_ds", "M_db",
    "M_rr", "M_vr", "M_vv", "M_rp",
    "N_rdot", "N_pdot", "N_vdot", "N_r", "N_p", "N_v", "N_vav", "N_pq", "N_dr",
)
# fmt: on
BASIC_DROPS: Final = ("Z_waw", "M_waw", "M_awq")  # the basic set leaves these out
# Those of the propeller's slip, eta - 1, that need no division where eta is u_c/u.
# fmt: off
SLIP_TERMS: Final = (
    "X_drdr_eta", "X_dsds_eta",
    "Y_r_eta", "Y_v_eta", "Y_dr_eta",
    "Z_q_eta", "Z_w_eta", "Z_ds_eta",
    "K_star_eta",
    "M_q_eta", "M_w_eta", "M_ds_eta",
    "N_r_eta", "N_v_eta", "N_dr_eta",
)
# A vessel file may also keep these; they are zero elsewhere.
EXTRA_TERMS: Final = (
    "X_vr", "X_qq", "X_rr", "X_rp", "X_wq", "X_vv", "X_ww",
    "Y_pq", "Y_qr", "Y_vq", "Y_wp", "Y_wr", "Y_vw",
    "Z_pp", "Z_rp", "Z_vp",
    "K_pap", "K_qr", "K_pq", "K_r", "K_vq", "K_wp", "K_wr", "K_vw", "K_star",
    "M_pp", "M_qaq", "M_vp",
    "N_rar", "N_avr", "N_qr", "N_wr", "N_wp", "N_vq", "N_vw",
    *SLIP_TERMS,
)
# fmt: on
