"""The microcylinder cloth as a BSDF of Mitsuba 3, in Dr.Jit: eval, pdf and sample.   [Miz 5-6; sampling own]

The shading frame's s is yarn 1 (u), t is yarn 2 (v); the back is black (use Mitsuba's `twosided`). The only parameter is
`numbers`, a fabric as JSON: sigma, gap, and for each tangent its yarn, tilt (radians), weight in the sum and in the
normaliser, A, eta, k_d, gamma_s, gamma_v (radians). This file stands alone, so that it can be handed on.
"""

import json
import math

import drjit as dr
import mitsuba as mi

COSINE = 0.2  # share of the samples that a cosine lobe about the normal takes: it carries all that lobes miss
LEAST_COS = 0.1  # of the view to the thread, in the lobes' weights


def wrap(x):
    """An angle brought into [-pi, pi]."""
    return dr.atan2(dr.sin(x), dr.cos(x))


def g_u(x, gamma):
    """Gaussian with unit integral."""
    return dr.exp(-dr.square(x / gamma)) * (1.0 / (math.sqrt(math.pi) * gamma))


def masked(sine_i, cosine_i, sine_o, cosine_o, sigma):
    """Shadowing-masking of two projected directions."""
    a_i, a_o = dr.atan2(sine_i, cosine_i), dr.atan2(sine_o, cosine_o)
    g = dr.exp(-dr.square(wrap(a_i - a_o) / sigma))
    y, z = dr.maximum(dr.cos(a_i), 0.0), dr.maximum(dr.cos(a_o), 0.0)
    value = (1.0 - g) * y * z + g * dr.minimum(y, z)
    least = dr.minimum(dr.square(sine_i) + dr.square(cosine_i), dr.square(sine_o) + dr.square(cosine_o))
    return dr.select(least < 1e-18, 0.0, value)


class Tangent:
    """One tangent of a yarn, with its yarn's numbers."""

    def __init__(self, numbers):
        (self.yarn, self.tilt, self.weight, self.norm, self.A, self.eta, self.k_d, self.gamma_s, self.gamma_v) = numbers
        self.c, self.s = math.cos(self.tilt), math.sin(self.tilt)
        self.F_0 = ((1.0 - self.eta) / (1.0 + self.eta)) ** 2

    def local(self, w):
        """(w . t, w . b, w . n)."""
        along, aside = (w.x, w.y) if self.yarn == 0 else (w.y, -w.x)
        return self.c * along - self.s * w.z, aside, self.s * along + self.c * w.z

    def F(self, cosine):
        """Schlick's Fresnel reflectance."""
        return self.F_0 + (1.0 - self.F_0) * (1.0 - cosine) ** 5

    def f(self, i, o):
        """(f_rs, f_rv / A) / cos^2 theta_d times cos theta_i, for local directions."""
        cos_i, cos_o = dr.sqrt(dr.square(i[1]) + dr.square(i[2])), dr.sqrt(dr.square(o[1]) + dr.square(o[2]))
        theta_i, theta_o = dr.atan2(i[0], cos_i), dr.atan2(o[0], cos_o)
        theta_d, theta_h = 0.5 * (theta_i - theta_o), 0.5 * (theta_i + theta_o)
        half = 0.5 * wrap(dr.atan2(i[1], i[2]) - dr.atan2(o[1], o[2]))
        F = self.F(dr.cos(theta_d) * dr.cos(half))
        scale = cos_i / dr.maximum(dr.square(dr.cos(theta_d)), 1e-12)
        surface = F * dr.cos(half) * g_u(theta_h, self.gamma_s)
        volume = dr.square(1.0 - F) * ((1.0 - self.k_d) * g_u(theta_h, self.gamma_v) + self.k_d)
        return surface * scale, volume * scale / dr.maximum(cos_i + cos_o, 1e-9)


class Lobe:
    """One lobe of a tangent as it is sampled, for a given view: its weight, and the densities of its angles."""

    def __init__(self, tangent, o, surface):
        self.tangent, self.surface = tangent, surface
        self.gamma = tangent.gamma_s if surface else tangent.gamma_v
        cos_o = dr.sqrt(dr.square(o[1]) + dr.square(o[2]))
        self.theta_o, self.phi_o = dr.atan2(o[0], cos_o), dr.atan2(o[1], o[2])
        quarter = 0.25 * math.pi
        self.low = dr.erf((0.5 * self.theta_o - quarter) / self.gamma)
        self.high = dr.erf((0.5 * self.theta_o + quarter) / self.gamma)
        self.Z = dr.maximum(0.5 * (self.high - self.low), 1e-6)
        self.a, self.b = dr.sin(-quarter - 0.5 * self.phi_o), dr.sin(quarter - 0.5 * self.phi_o)
        F = tangent.F(dr.cos(self.theta_o) * dr.cos(0.5 * self.phi_o))
        c = dr.maximum(cos_o, LEAST_COS)
        cos_psi = o[2] / dr.maximum(dr.sqrt(dr.square(o[0]) + dr.square(o[2])), 1e-9)
        seen = (dr.cos(self.phi_o) > 0.0) & (cos_psi > 0.0)
        if surface:
            weight = tangent.weight * cos_psi * 4.0 * F * self.Z / c
        else:
            A = tangent.A
            luminance = max(0.2126 * A[0] + 0.7152 * A[1] + 0.0722 * A[2], 1e-4)
            factor = luminance * (1.0 - tangent.k_d) * 2.0
            weight = tangent.weight * cos_psi * factor * dr.square(1.0 - F) * self.Z / dr.square(c)
        self.weight = dr.select(seen, weight, 0.0)

    def pdf(self, i):
        """Density per solid angle at a local direction."""
        cos_i = dr.sqrt(dr.square(i[1]) + dr.square(i[2]))
        theta_h = 0.5 * (dr.atan2(i[0], cos_i) + self.theta_o)
        p_theta = g_u(theta_h, self.gamma) / (2.0 * self.Z)
        phi = dr.atan2(i[1], i[2])
        if self.surface:
            p_phi = dr.cos(0.5 * (phi - self.phi_o)) / dr.maximum(2.0 * (self.b - self.a), 1e-9)
        else:
            p_phi = 0.5 * dr.cos(phi)
        return dr.select(i[2] > 0.0, dr.maximum(p_theta * p_phi, 0.0) / dr.maximum(cos_i, 1e-6), 0.0)

    def direction(self, u, v):
        """A direction in the surface frame."""
        theta_h = self.gamma * dr.erfinv(dr.clip(self.low + u * (self.high - self.low), -0.9999999, 0.9999999))
        theta = dr.clip(2.0 * theta_h - self.theta_o, -0.5 * math.pi, 0.5 * math.pi)
        if self.surface:
            phi = self.phi_o + 2.0 * dr.asin(dr.clip(self.a + v * (self.b - self.a), -1.0, 1.0))
        else:
            phi = dr.asin(dr.clip(2.0 * v - 1.0, -1.0, 1.0))
        t, b, n = dr.sin(theta), dr.cos(theta) * dr.sin(phi), dr.cos(theta) * dr.cos(phi)
        k = self.tangent
        along, z = k.c * t + k.s * n, k.c * n - k.s * t
        return mi.Vector3f(along, b, z) if k.yarn == 0 else mi.Vector3f(-b, along, z)


def make_bsdf():
    """The class for the variant that is set; Mitsuba's classes belong to a variant."""

    class Microcylinder(mi.BSDF):
        """See the file's head."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            numbers = json.loads(props["numbers"])
            self.sigma, self.gap = numbers["sigma"], numbers["gap"]
            self.tangents = [Tangent(row) for row in numbers["tangents"]]
            self.m_components = [mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide | mi.BSDFFlags.Anisotropic]
            self.m_flags = self.m_components[0]

        def lobes(self, wo):
            """The lobes of a view and the sum of their weights."""
            out = [Lobe(t, t.local(wo), surface) for t in self.tangents for surface in (True, False)]
            return out, sum((lobe.weight for lobe in out), mi.Float(0.0))

        def eval(self, ctx, si, wo, active=True):
            """f cos of the light's direction `wo`; Mitsuba's si.wi is the view."""
            view, light = si.wi, wo
            total, Q = mi.Color3f(0.0), self.gap * dr.maximum(view.z, 0.0)
            for t in self.tangents:
                i, o = t.local(light), t.local(view)
                P = masked(i[0], i[2], o[0], o[2], self.sigma)
                Q += t.norm * P
                surface, volume = t.f(i, o)
                R = t.weight * masked(i[1], i[2], o[1], o[2], self.sigma) * P
                total += dr.select(R > 0.0, R * (surface + volume * mi.Color3f(t.A)), 0.0)
            lit = (view.z > 0.0) & (light.z > 0.0) & (Q > 0.0) & active
            return dr.select(lit, total / dr.select(Q > 0.0, Q, 1.0), 0.0)

        def pdf(self, ctx, si, wo, active=True):
            """Density of the samples that count per solid angle: where the cloth is black none does."""
            seen = mi.Bool(False)
            for t in self.tangents:
                seen |= (t.local(wo)[2] > 0.0) & (t.local(si.wi)[2] > 0.0)
            lobes, total = self.lobes(si.wi)
            sum_of_lobes = mi.Float(0.0)
            for lobe in lobes:
                sum_of_lobes += lobe.weight * lobe.pdf(lobe.tangent.local(wo))
            cosine = dr.maximum(wo.z, 0.0) / math.pi
            share = dr.select(total > 0.0, COSINE, 1.0)
            value = share * cosine + (1.0 - share) * sum_of_lobes / dr.select(total > 0.0, total, 1.0)
            return dr.select((si.wi.z > 0.0) & (wo.z > 0.0) & seen & active, value, 0.0)

        def sample(self, ctx, si, sample1, sample2, active=True):
            """A direction of a lobe, or of the cosine."""
            lobes, total = self.lobes(si.wi)
            wo = mi.warp.square_to_cosine_hemisphere(sample2)
            choice = (sample1 - COSINE) / (1.0 - COSINE) * total
            below = mi.Float(0.0)
            for lobe in lobes:
                above = below + lobe.weight
                mine = (sample1 >= COSINE) & (total > 0.0) & (choice >= below) & (choice < above)
                wo = dr.select(mine, lobe.direction(sample2.x, sample2.y), wo)
                below = above
            bs = mi.BSDFSample3f()
            bs.wo, bs.eta = wo, 1.0
            bs.sampled_type, bs.sampled_component = mi.UInt32(+self.m_flags), mi.UInt32(0)
            bs.pdf = self.pdf(ctx, si, wo, active)
            valid = (bs.pdf > 0.0) & active
            value = self.eval(ctx, si, wo, valid) / dr.select(valid, bs.pdf, 1.0)
            return bs, dr.select(valid, value, 0.0)

        def eval_pdf(self, ctx, si, wo, active=True):
            """Both at once."""
            return self.eval(ctx, si, wo, active), self.pdf(ctx, si, wo, active)

        def to_string(self):
            """For people."""
            return f"Microcylinder[{len(self.tangents)} tangents]"

    return Microcylinder


def register(name="microcylinder"):
    """Make the plugin known to the variant that is set; after another `mi.set_variant` call it again."""
    mi.register_bsdf(name, make_bsdf())
