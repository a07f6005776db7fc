"""LOWTRAN7's molecular band model over arrays: transmittance of any path through any profile.

F. X. Kneizys et al., *Users Guide to LOWTRAN 7*, AFGL-TR-88-0177 (1988); its double exponential functions are those
of J. H. Pierluissi and C. E. Maragoudakis, *Molecular Transmission Band Models for LOWTRAN*, AFGL-TR-86-0272
(1986). The coefficients lie in ``catalogs/atmospheres/lowtran7-band-model.nc``.

The transmittance of one gas at one wavenumber is exp(-(W 10^C')^a), with the amount W of the path scaled to standard
pressure and temperature, and the gases multiply. So the optical depths add, each is a product of a factor of the path,
W^a, and a factor of the wavenumber, 10^(a C'), and all paths at all wavenumbers are one matrix product.
"""
