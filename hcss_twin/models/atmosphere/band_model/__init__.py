"""LOWTRAN7's molecular band model, vectorised: transmittance of any path through any profile.

F. X. Kneizys et al., *Users Guide to LOWTRAN 7*, AFGL-TR-88-0177 (1988); the double-exponential functions are from J.
H. Pierluissi and C. E. Maragoudakis, *Molecular Transmission Band Models for LOWTRAN*, AFGL-TR-86-0272 (1986). Their
coefficients are in ``catalogs/atmospheres/lowtran7-band-model.nc``; the default ones, fitted to RRTMGP, are in
``band-model-rrtmgp.nc``.

The transmittance of one gas at one wavenumber is exp(-(W 10^C')^a), where W is the absorber amount of the path, scaled
to standard pressure and temperature. The transmittances of the gases multiply, so their optical depths add. Each
optical depth is a path factor W^a times a spectral factor 10^(a C'), so that one matrix product covers all paths and
wavenumbers.
"""
