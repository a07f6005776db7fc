"""Constants of nature that define the SI since 2019, exact (BIPM, *The International System of Units*, 9th edition)."""

PLANCK_J_S = 6.62607015e-34
SPEED_OF_LIGHT_M_S = 299792458.0
BOLTZMANN_J_K = 1.380649e-23
