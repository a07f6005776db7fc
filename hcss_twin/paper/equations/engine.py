"""Equations beyond the paper's: what the default models and the engine compute."""

from __future__ import annotations

from hcss_twin.paper.equations.entry import Equation

ENGINE: dict[str, tuple[Equation, ...]] = {
    "Light and geometry": (
        Equation(
            "Black-body radiance",
            r"B(\tilde\nu, T) = \frac{2 h c^2 \tilde\nu^3}{\exp(h c \tilde\nu / k T) - 1}",
            ("physics.planck.planck",),
            "M. Planck, Ann. Phys. 309, 553 (1901); constants of the SI (2019)",
            note="Wavenumbers in cm-1, radiance per cm-1.",
        ),
        Equation(
            "Radiance of a band",
            r"L_{band} = \int R(\lambda)\, L(\lambda)\, d\lambda",
            ("models.radiance.spectral_grid.dense_grid", "models.radiance.reference.reference_radiance"),
            "definition",
            note="Not divided by the integral of the response R.",
        ),
        Equation(
            "Brightness temperature",
            r"\int R(\lambda)\, B(\lambda, T_B)\, d\lambda = L_{band}",
            ("models.radiance.spectral_grid.BrightnessTemperature",),
            "definition",
        ),
        Equation(
            "Position of the sun",
            r"\theta_0, \varphi_0, d = f(\mathrm{time}, \mathrm{latitude}, \mathrm{longitude})",
            ("physics.sun.sun_position",),
            "I. Reda and A. Andreas, NREL/TP-560-34302 (2008)",
            note="Apparent (refracted) zenith at sea level. Reproduces all 32 angles of the paper's Tables V and VI.",
        ),
        Equation(
            "Slant path through spherical shells",
            r"s = \sqrt{(R + z_2)^2 - R^2 \sin^2\theta} - \sqrt{(R + z_1)^2 - R^2 \sin^2\theta}",
            ("physics.profile.slant_length_m", "physics.profile.Profile.airmass"),
            "geometry",
            note="theta is the zenith angle at the surface point, R the radius of the Earth.",
        ),
        Equation(
            "Image plane on the globe",
            r"\sin\phi = \cos c\, \sin\phi_1 + \frac{y}{\rho} \sin c\, \cos\phi_1, \qquad c = \rho / R",
            ("physics.geodesy.to_geographic",),
            "J. P. Snyder, USGS Professional Paper 1395 (1987), eqs 20-14, 20-15 and 25-15",
        ),
    ),
    "Air": (
        Equation(
            "Transmittance of a whole path",
            r"T(\tilde\nu) = \exp\left[-\sum_j C_j(\tilde\nu)\, \Big(\sum_{legs} W_j\Big)^{a_j} - "
            r"\tau_{continua} - \tau_{aerosol}\right]",
            (
                "models.atmosphere.band_model.provider.BandModelTransmittance.transmittance",
                "models.atmosphere.band_model.absorption.Absorption.transmittance",
            ),
            "F. X. Kneizys et al., LOWTRAN 7, AFGL-TR-88-0177 (1988); J. H. Pierluissi and C. E. "
            "Maragoudakis, AFGL-TR-86-0272 (1986)",
            note="Equivalent absorber amounts W are added over the legs; transmittances of legs are never multiplied.",
        ),
        Equation(
            "Path radiance",
            r"L_{atm} = \sum_n B(T_n) \left[T(\mathrm{top}_n \to \mathrm{space}) - T(\mathrm{bottom}_n \to "
            r"\mathrm{space})\right]",
            ("models.atmosphere.path_radiance.path_radiance",),
            "Schwarzschild's equation in layers",
            note="An isothermal atmosphere gives (1 - T) B exactly.",
        ),
        Equation(
            "Sunlight scattered once by the air",
            r"L = E_{sun} \sum_n \frac{P_n(\theta)}{4 \pi}\, \Delta\tau_n\, T(\mathrm{sun} \to n \to "
            r"\mathrm{sensor})",
            ("models.atmosphere.band_model.single_scattering.ScatteredSunlight.radiance",),
            "F. X. Kneizys et al., LOWTRAN 7, AFGL-TR-88-0177 (1988), single scattering",
            note="Delta tau: optical depth of scattering along the line of sight; T: of the whole way of the light.",
        ),
    ),
    "Sea": (
        Equation(
            "Reflectance of a facet",
            r"\rho = \frac{1}{2} \left[\left|\frac{\mu - u}{\mu + u}\right|^2 + \left|\frac{m^2 \mu - "
            r"u}{m^2 \mu + u}\right|^2\right], \qquad u = \sqrt{m^2 - 1 + \mu^2}",
            ("physics.fresnel.unpolarised_reflectance",),
            "M. Born and E. Wolf, Principles of Optics, 7th ed., section 1.5.2",
        ),
        Equation(
            "Mean-square slope of the waves",
            r"s^2 = 0.003 + 0.00512\, U",
            ("models.sea.slope_statistics.mean_square_slope", "models.sea.slope_statistics.slope_statistics"),
            "C. Cox and W. Munk, J. Opt. Soc. Am. 44, 838 (1954)",
        ),
        Equation(
            "Density of slopes",
            r"P(z_x, z_y) = \frac{1}{\pi s^2} \exp\left(-\frac{z_x^2 + z_y^2}{s^2}\right)",
            ("models.sea.slope_statistics.slope_density", "models.sea.slope_statistics.SlopeStatistics.density"),
            "Cox and Munk (1954), eq 18",
            note="`rough-sea` takes upwind and crosswind slopes apart, on request with the Gram-Charlier series.",
        ),
        Equation(
            "BRDF of the sea",
            r"f = \frac{\rho(\chi)\, P(z_x, z_y)}{4\, \mu_r\, \mu_i\, \mu_n^4}",
            (
                "models.sea.cox_munk.CoxMunkSea.brdf",
                "models.sea.cox_munk.mirror_facet",
                "models.sea.rough_sea.RoughSea.brdf",
            ),
            "Cox and Munk (1954)",
            note="mu_n: cosine of the tilt of the facet that mirrors one direction into the other.",
        ),
        Equation(
            "Emissivity of the sea",
            r"\epsilon = 1 - \int \rho(\chi) \frac{\cos\chi}{\mu \cos\theta_n} P(z_x, z_y)\, dz_x\, dz_y",
            (
                "models.sea.cox_munk.CoxMunkSea.emissivity",
                "models.sea.facets.facet_weights",
                "models.sea.rough_sea.RoughSea.emissivity",
            ),
            "K. Masuda et al., Remote Sens. Environ. 24, 313 (1988)",
            note="`rough-sea` adds the second reflection and the hiding of waves.",
        ),
        Equation(
            "Waves that hide one another",
            r"\Lambda = \frac{\exp(-v^2)}{2 v \sqrt{\pi}} - \frac{1}{2} \mathrm{erfc}(v), \qquad v = "
            r"\frac{\cot\theta}{\sqrt{2 \sigma^2}}",
            ("models.sea.facets.smith_lambda", "models.sea.facets.both_seen"),
            "B. G. Smith, IEEE Trans. Antennas Propag. 15, 668 (1967)",
        ),
        Equation(
            "Spectrum of a young sea",
            r"S(\omega) = \frac{\alpha g^2}{\omega^5} \exp\left[-\frac{5}{4} "
            r"\left(\frac{\omega_p}{\omega}\right)^4\right] 3.3^r",
            ("models.sea.wave_spectrum.spectrum_m2_s",),
            "K. Hasselmann et al., Dtsch. Hydrogr. Z. A8, no. 12 (1973)",
        ),
        Equation(
            "Foam",
            r"W = a\, U^b",
            ("models.sea.sea_water.foam_coverage", "models.sea.sea_water.foam_reflectance"),
            "E. C. Monahan and I. O'Muircheartaigh, J. Phys. Oceanogr. 10, 2094 (1980)",
        ),
    ),
    "Clouds": (
        Equation(
            "Interpolation that keeps the variance",
            r"S(x) = \frac{\sum_i w_i(x)\, A_i}{\sqrt{\sum_i w_i(x)^2}}",
            ("models.clouds.fractal.rows.cubic_weights",),
            "weights: R. G. Keys, IEEE Trans. ASSP 29, 1153 (1981), eq 15",
        ),
        Equation(
            "Effective radius and variance",
            r"r_e = \frac{\langle r^3 \rangle}{\langle r^2 \rangle}, \qquad v_e = \frac{\langle r^4 "
            r"\rangle \langle r^2 \rangle}{\langle r^3 \rangle^2} - 1",
            (
                "models.optics.size_distribution.effective_radius_um",
                "models.optics.size_distribution.effective_variance",
            ),
            "J. E. Hansen and L. D. Travis, Space Sci. Rev. 16, 527 (1974)",
        ),
        Equation(
            "Efficiencies of a sphere",
            r"Q_{ext} = \frac{2}{x^2} \sum_n (2 n + 1)\, \mathrm{Re}(a_n + b_n), \qquad Q_{sca} = "
            r"\frac{2}{x^2} \sum_n (2 n + 1) (|a_n|^2 + |b_n|^2)",
            ("models.optics.spheres.mie_efficiencies",),
            "C. F. Bohren and D. R. Huffman, Absorption and Scattering of Light by Small Particles (1983), chapter 4",
        ),
        Equation(
            "Moments of the phase function",
            r"\chi_l = \frac{1}{2} \int_{-1}^{1} P(\mu)\, P_l(\mu)\, d\mu",
            ("models.optics.bulk.bulk_moments", "models.optics.spheres.phase_function"),
            "definition; integrated over droplets in closed form",
        ),
        Equation(
            "Delta-M scaling of the forward peak",
            r"\tau' = (1 - w f)\, \tau, \qquad w' = \frac{(1 - f)\, w}{1 - w f}, \qquad \chi'_l = "
            r"\frac{\chi_l - f}{1 - f}",
            ("physics.multiple_scattering.phase_function.delta_m",),
            "W. J. Wiscombe, J. Atmos. Sci. 34, 1408 (1977), eqs 10 to 20",
        ),
        Equation(
            "Doubling of a layer",
            r"(1 - R R) D = T + R R E, \qquad R' = R + (E + T) U, \qquad T' = E D + T E + T D",
            ("physics.multiple_scattering.doubling.solve_chains", "physics.multiple_scattering.layer.solve_layers"),
            "H. C. van de Hulst, Multiple Light Scattering (1980), chapter 4",
            note="E direct and T diffuse transmission, R reflection, D and U the light between both halves.",
        ),
        Equation(
            "Emissivity of a cloud",
            r"\epsilon = 1 - E - \sum_j R_j - \sum_j T_j",
            ("physics.multiple_scattering.layer.solve_layers",),
            "Kirchhoff's law",
        ),
        Equation(
            "Two streams, in closed form",
            r"\frac{ds}{dt} = -\frac{3}{2} (1 - w' g')\, d, \qquad \frac{dd}{dt} = -2 (1 - w')\, s",
            ("physics.multiple_scattering.two_stream.solve_layers_two_stream",),
            "J. H. Joseph et al., J. Atmos. Sci. 33, 2452 (1976); O. B. Toon et al., J. Geophys. Res. 94, 16287 (1989)",
        ),
    ),
    "The whole column": (
        Equation(
            "Light between sea, clouds and sky",
            r"u = P\, u + S",
            ("models.radiance.physical.closure.close", "models.radiance.physical.model.Physical.cloudy"),
            "balance of energy at every face ([physical radiance](physical.md))",
            note="u: radiance along all streams in all gaps, P: what sea and clouds pass on, S: what they "
            "and the air emit or turn from the "
            "sun. An isothermal enclosure is black.",
        ),
        Equation(
            "Displacement by a slant path",
            r"\Delta = h \tan\theta",
            ("plan.slant_paths.displacement_m",),
            "geometry",
            note="Of what is seen (parallax) and of shadows.",
        ),
    ),
    "Certificate": (
        Equation(
            "Share of pixels that may exceed while none of n checked does",
            r"p = 1 - 0.05^{1/n}",
            ("engine.certificate.certificate.share_drawn_alike", "engine.certificate.certificate.share_of_all"),
            "C. J. Clopper and E. S. Pearson, Biometrika 26, 404 (1934)",
        ),
    ),
}
