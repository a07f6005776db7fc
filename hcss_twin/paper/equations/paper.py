"""The numbered equations of the HCSS paper, in the form in which they are computed."""

from __future__ import annotations

from hcss_twin.paper.equations.entry import Equation

TITLE = 'W. Sun et al., "Complex Cloud-Sea Background Simulation for Space-Based Infrared Payload Digital Twin"'

PAPER: tuple[Equation, ...] = (
    Equation(
        "Pierson-Moskowitz spectrum of the sea's elevation",
        r"S(\omega) = \frac{\alpha g^2}{\omega^5} \exp\left[-\beta \left(\frac{g}{U \omega}\right)^4\right]",
        ("models.sea.pierson_moskowitz.spectrum_m2_s",),
        paper=1,
        note="alpha = 8.1e-3, beta = 0.74, U the wind speed. 10 m/s gives a significant wave height of 2.13 m.",
    ),
    Equation(
        "Fractal field: a sum of interpolated noise over octaves",
        r"V_n(X) = \sum_{k=k_0}^{k_{max}} \gamma^{-kH}\, S_n\left(\gamma^k \frac{X}{L}\right)",
        ("models.clouds.fractal.field.FractalField.window", "models.clouds.fractal.rows.cubic_weights"),
        paper=2,
        note="S_n interpolates independent normals of a lattice. Weights are normalised to keep the "
        "variance 1, which plain cubic "
        "interpolation does not; L counts cells per 16 km.",
    ),
    Equation(
        "Fractal field in space and time",
        r"V_4(X(x, y, z, t)) = \sum_k \gamma^{-kH}\, S_4\left(\gamma^k \frac{X(x, y, z, t)}{L}\right)",
        ("models.clouds.fractal.field.FractalField.window",),
        paper=3,
        note="Computed in x, y and t: thickness comes from eq 7, not from a cut in z.",
    ),
    Equation(
        "Drift with the wind",
        r"V_4(X(x + v_x t, y + v_y t, z, t))",
        ("models.clouds.fractal.generator.FractalClouds.field", "models.clouds.fractal.generator.displacement_pixels"),
        paper=4,
        note="The paper prints v_x and v_y without the time. The platform's motion is added.",
    ),
    Equation(
        "Cloud fraction value, uniform on 0 to 1",
        r"p = \frac{1}{2}\left[1 + \mathrm{erf}\left(\frac{V}{\sqrt{2}}\right)\right]",
        ("models.clouds.coverage.cloud_fraction_value", "models.clouds.coverage.cloudy_pixels"),
        paper=5,
        note="The cloudy pixels are the highest ones, exactly as many as the coverage asks for.",
    ),
    Equation(
        "Fractal dimension by box counting",
        r"FD = \lim_{\epsilon \to 0} \frac{\log N(\epsilon)}{\log(1/\epsilon)}",
        ("analysis.measures.box_counting.body_dimension",),
        paper=6,
        note="The paper's limit runs to infinity. The body under the grey-level surface is what reproduces "
        "its numbers; other estimators "
        "measure surfaces ([fractal dimension](fractal-dimension.md)).",
    ),
    Equation(
        "Cloud thickness",
        r"Th = Th_{min} + (Th_{max} - Th_{min}) \frac{C - C_{min}}{C_{max} - C_{min}}",
        (
            "models.clouds.thickness.frame_thickness",
            "models.clouds.thickness.field_thickness",
            "models.clouds.imagery.cloudiness.relative_grey",
        ),
        paper=7,
        note="0 where clear. `edge_taper` and `brightness_exponent` are extensions.",
    ),
    Equation(
        "Cloud emissivity without scattering",
        r"\epsilon_{cloud} = 1 - \exp(-K_{abs}\, z)",
        ("models.radiance.as_printed.cloud_emissivity",),
        paper=8,
        note="z is the geometric thickness; the paper calls it optical. `as-printed` only: `physical` "
        "solves the transfer.",
    ),
    Equation(
        "Absorption coefficient of water cloud",
        r"K_{abs}(\lambda) = \pi \int_{r_1}^{r_2} r^2\, Q_{abs}(\lambda, r)\, n(r)\, dr, \qquad n(r) = a\, "
        r"r^\alpha \exp(-b\, r^\nu)",
        ("models.optics.bulk.bulk_properties", "models.optics.size_distribution.density"),
        paper=9,
        note="a follows from the number of particles per volume.",
    ),
    Equation(
        "Absorption coefficient of ice cloud",
        r"K_{abs}(\lambda) = (1 - w_0)\, K_{ext}",
        ("models.optics.bulk.BulkProperties.absorption_m1", "models.optics.ice_crystals.CrystalRatios"),
        paper=10,
        note="With the volume coefficient K_ext where the paper has the efficiency Q_ext.",
    ),
    Equation(
        "Single-scattering albedo",
        r"w_0 = \frac{Q_{sca}}{Q_{ext}}",
        ("models.optics.bulk.BulkProperties.albedo",),
        paper=11,
    ),
    Equation(
        "Reflection of sunlight by a cloud, scattered once",
        r"BRDF = \frac{w_0}{4 \pi} P(\theta) \frac{\cos\theta_i}{\cos\theta_i + \cos\theta_r}",
        ("models.radiance.as_printed.cloud_brdf",),
        paper=12,
        note="`as-printed` only.",
    ),
    Equation(
        "Henyey-Greenstein phase function",
        r"P(\theta) = \frac{1 - \rho^2}{(1 + \rho^2 - 2 \rho \cos\theta)^{3/2}}",
        ("physics.multiple_scattering.phase_function.henyey_greenstein",),
        paper=13,
        note="rho is the asymmetry parameter. `physical` uses the whole phase function of the particles.",
    ),
    Equation(
        "Scattering angle",
        r"\cos\theta = -\cos\theta_i \cos\theta_r - \sin\theta_i \sin\theta_r \cos(\varphi_i - \varphi_r)",
        ("physics.geometry.scattering_cosine", "physics.geometry.scattering_cosine_literal"),
        paper=14,
        note="The paper's signs differ and make eq 13 peak into the view, which its own tables exclude; "
        "`literal_eq14` restores them.",
    ),
    Equation(
        "Thermal emission of a cloud",
        r"L_{c,self} = \epsilon_{cloud}(\lambda)\, \frac{M(T_{cloud}, \lambda)}{\pi}",
        ("models.radiance.as_printed.AsPrinted.cloudy", "physics.planck.planck"),
        paper=15,
    ),
    Equation(
        "Sunlight reflected by a cloud",
        r"L_{c,refl} = \tau_{s-c}\, E_{sun} \cos\theta_i\, BRDF",
        ("models.radiance.as_printed.AsPrinted.cloudy",),
        paper=16,
        note="E_sun is the sun's irradiance (the paper's L_sun d omega); the transmittance is that of the "
        "whole path from the sun to the "
        "cloud and on to the sensor.",
    ),
    Equation(
        "Thermal emission of the sea",
        r"L_{s,self} = \epsilon_{sea}(\lambda)\, \frac{M(T_{sea}, \lambda)}{\pi}",
        ("models.radiance.as_printed.AsPrinted.clear", "models.sea.cox_munk.CoxMunkSea.emissivity"),
        paper=17,
    ),
    Equation(
        "Sunlight reflected by the sea",
        r"L_{s,refl} = \tau_{s-s}\, E_{sun} \cos\theta_i\, BRDF",
        ("models.radiance.as_printed.AsPrinted.clear", "models.sea.cox_munk.CoxMunkSea.brdf"),
        paper=18,
        note="The paper's transmittance is that from the sea to the sensor; the sun's way down is added "
        "(`literal_eq18` leaves it out).",
    ),
    Equation(
        "Clear column",
        r"L_{total} = \tau_s (L_{s,self} + L_{s,refl}) + L_{atm}",
        ("models.radiance.as_printed.AsPrinted.clear", "models.atmosphere.path_radiance.path_radiance"),
        paper=19,
    ),
    Equation(
        "Cloudy column",
        r"L_{total} = \tau_c (L_{c,self} + L_{c,refl}) + \tau_{sc} (L_{s,self} + L_{s,refl}) + L_{atm}",
        ("models.radiance.as_printed.AsPrinted.cloudy",),
        paper=20,
        note="The paper adds the sea a second time, without the cloud, and the path radiance of the whole "
        "column; its tables exclude both "
        "(`literal_eq19`, `literal_eq20`).",
    ),
    Equation(
        "Entropy of the two-dimensional histogram",
        r"EV = -\sum_{G_L} \sum_{G_R} Pr(G_L, G_R) \log_2 Pr(G_L, G_R)",
        ("analysis.measures.histogram_metrics.histogram_metrics",),
        paper=21,
    ),
    Equation(
        "Density of the two-dimensional histogram",
        r"Den = \frac{1}{(M - 1) N} \sum_{G_L} \sum_{G_R} \frac{G(G_L, G_R)}{1 + |G_R - G_L|}",
        ("analysis.measures.histogram_metrics.histogram_metrics",),
        paper=22,
        note="At most 1; the paper prints ten times it.",
    ),
    Equation(
        "Mean height of the histogram's diagonal",
        r"DP = \frac{1}{W - 1} \sum_{G} G(G, G)",
        ("analysis.measures.histogram_metrics.histogram_metrics",),
        paper=23,
    ),
    Equation(
        "Difference of two morphologies",
        r"RMSE = \sqrt{\tfrac{1}{4} (er_{EV}^2 + er_{Den}^2 + er_{DP}^2 + er_{FD}^2)}, \qquad er_m = "
        r"\frac{|m_{true} - m_{sim}|}{m_{sim}}",
        ("analysis.measures.morphology.relative_errors", "analysis.measures.morphology.eq_24"),
        paper=24,
    ),
)
