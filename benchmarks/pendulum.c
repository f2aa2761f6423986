// Copyright 2026 cdp_ident maintainers
// SPDX-License-Identifier: Apache-2.0
/* What the package computes, written by hand for a C compiler: the paper's model by the classical Runge-Kutta method.
 * `population` and `windows` are the arithmetic of cdp_ident.model.population and of cdp_ident.model.motions without
 * effects, several motions side by side in vector lanes; `one_by_one` is what one writes without thinking of lanes.
 * The coefficients are A23, A33, a1, c1, c2, each over A22, L and g; m2 l2 over A22 is A23 / L. */
#include <math.h>
#include <string.h>

#define LANES 16   /* members of a population side by side */
#define WINDOWS 8  /* windows side by side */
#define N 11       /* directions of derivatives: four of the start, seven coefficients */
#define OVER(count) _Pragma("omp simd") for (int i = 0; i < count; i++)

static inline void sine_cosine(double angle, double *sine, double *cosine) {
    double turns = floor(angle * (1.0 / (2.0 * M_PI)) + 0.5);
    double p = ((angle - turns * (2.0 * M_PI)) - turns * 2.4492935982947064e-16) * 0.25, q = p * p;
    double s = p * (1 + q * (-1.0 / 6 + q * (1.0 / 120 + q * (-1.0 / 5040 + q * (1.0 / 362880 + q * (-1.0 / 39916800
        + q * (1.0 / 6227020800.0 - q / 1307674368000.0)))))));
    double c = 1 + q * (-1.0 / 2 + q * (1.0 / 24 + q * (-1.0 / 720 + q * (1.0 / 40320 + q * (-1.0 / 3628800
        + q * (1.0 / 479001600 - q / 87178291200.0))))));
    double hs = 2 * s * c, hc = 1 - 2 * s * s;
    *sine = 2 * hs * hc, *cosine = 1 - 2 * hs * hs;
}

static inline void accelerations(double sin1, double cos1, double sin2, double cos2, double w1, double w2, double A23,
                                 double A33, double a1, double c1, double c2, double m2l2, double g, double *al1,
                                 double *al2) {
    double s = A23 * (sin1 * cos2 - cos1 * sin2), m = A23 * (cos1 * cos2 + sin1 * sin2), r = c2 * (w1 - w2);
    double n1 = a1 * g * sin1 - s * w2 * w2 - c1 * w1 - r, n2 = m2l2 * g * sin2 + s * w1 * w1 + r;
    double inverse = 1 / (A33 - m * m);
    *al1 = (A33 * n1 - m * n2) * inverse, *al2 = (n2 - m * n1) * inverse;
}

/* coefficients (blocks, 7, LANES), start (4), measured angles (steps + 1, 2) at the steps; squared errors (blocks,
 * LANES). */
void population(const double *coefficients, int blocks, const double *start, int steps, double h,
                const double *measured, double *errors) {
    for (int block = 0; block < blocks; block++) {
        const double *k = coefficients + block * 7 * LANES;
        double x1[LANES], x2[LANES], v1[LANES], v2[LANES], total[LANES], m2l2[LANES];
        OVER(LANES) m2l2[i] = k[i] / k[5 * LANES + i];
        OVER(LANES) x1[i] = start[0], x2[i] = start[1], v1[i] = start[2], v2[i] = start[3], total[i] = 0;
        for (int step = 0; step <= steps; step++) {
            const double measured1 = measured[2 * step], measured2 = measured[2 * step + 1];
            OVER(LANES) {
                double e1 = x1[i] - measured1, e2 = x2[i] - measured2;
                total[i] += e1 * e1 + e2 * e2;
                double t1 = x1[i], t2 = x2[i], w1 = v1[i], w2 = v2[i], s1, c1, s2, c2, f1, f2;
                double sum_t1 = 0, sum_t2 = 0, sum_w1 = 0, sum_w2 = 0;
#define STAGE(weight, offset)                                                                                    \
    sine_cosine(t1, &s1, &c1), sine_cosine(t2, &s2, &c2);                                                        \
    accelerations(s1, c1, s2, c2, w1, w2, k[i], k[LANES + i], k[2 * LANES + i], k[3 * LANES + i],                \
                  k[4 * LANES + i], m2l2[i], k[6 * LANES + i], &f1, &f2);                                         \
    sum_t1 += weight * w1, sum_t2 += weight * w2, sum_w1 += weight * f1, sum_w2 += weight * f2;                  \
    t1 = x1[i] + offset * w1, t2 = x2[i] + offset * w2, w1 = v1[i] + offset * f1, w2 = v2[i] + offset * f2;
                STAGE(1, 0.5 * h) STAGE(2, 0.5 * h) STAGE(2, h) STAGE(1, h)
                x1[i] += h / 6 * sum_t1, x2[i] += h / 6 * sum_t2, v1[i] += h / 6 * sum_w1, v2[i] += h / 6 * sum_w2;
            }
        }
        memcpy(errors + block * LANES, total, sizeof total);
    }
}

/* The same for coefficients (members, 7), with the library's sine and cosine. */
void one_by_one(const double *coefficients, int members, const double *start, int steps, double h,
                const double *measured, double *errors) {
    for (int member = 0; member < members; member++) {
        const double *k = coefficients + 7 * member;
        double x[4], at[4], sum[4], total = 0, m2l2 = k[0] / k[5];
        memcpy(x, start, sizeof x);
        for (int step = 0; step <= steps; step++) {
            double e1 = x[0] - measured[2 * step], e2 = x[1] - measured[2 * step + 1];
            total += e1 * e1 + e2 * e2;
            memcpy(at, x, sizeof x), memset(sum, 0, sizeof sum);
            for (int stage = 0; stage < 4; stage++) {
                double weight = stage == 0 || stage == 3 ? 1 : 2, offset = stage < 2 ? 0.5 * h : h;
                double f[4] = {at[2], at[3]};
                accelerations(sin(at[0]), cos(at[0]), sin(at[1]), cos(at[1]), f[0], f[1], k[0], k[1], k[2], k[3], k[4],
                              m2l2, k[6], f + 2, f + 3);
                for (int r = 0; r < 4; r++) sum[r] += weight * f[r], at[r] = x[r] + offset * f[r];
            }
            for (int r = 0; r < 4; r++) x[r] += h / 6 * sum[r];
        }
        errors[member] = total;
    }
}

typedef double row[WINDOWS];

static void rates(const double *k, row *x, row *out, row *by, row (*direct)[2]) {
    const double A23 = k[0], A33 = k[1], a1 = k[2], c1 = k[3], c2 = k[4], L = k[5], g = k[6];
    const double m2l2 = A23 / L;
    OVER(WINDOWS) {
        double sin1, cos1, sin2, cos2, w1 = x[2][i], w2 = x[3][i];
        sine_cosine(x[0][i], &sin1, &cos1), sine_cosine(x[1][i], &sin2, &cos2);
        double sd = sin1 * cos2 - cos1 * sin2, c = cos1 * cos2 + sin1 * sin2, s = A23 * sd, m = A23 * c;
        double inverse = 1 / (A33 - m * m), i11 = A33 * inverse, i12 = -m * inverse, i22 = inverse, r = w1 - w2;
        double p1 = g * sin1, p2 = g * sin2;
        double n1 = a1 * p1 - s * w2 * w2 - c1 * w1 - c2 * r, n2 = m2l2 * p2 + s * w1 * w1 + c2 * r;
        double al1 = i11 * n1 + i12 * n2, al2 = i12 * n1 + i22 * n2;
        double b1 = m * w2 * w2 - s * al2, b2 = m * w1 * w1 + s * al1;
        double d[N][2] = {
            {a1 * g * cos1 - b1, b2}, {b1, m2l2 * g * cos2 - b2}, {-c1 - c2, 2 * s * w1 + c2}, {c2 - 2 * s * w2, -c2},
            {-sd * w2 * w2 - c * al2, sd * w1 * w1 - c * al1 + p2 / L}, {0, -al2}, {p1, 0}, {-w1, 0}, {-r, r},
            {0, -m2l2 * p2 / L}, {a1 * sin1, m2l2 * sin2}};
        out[0][i] = w1, out[1][i] = w2, out[2][i] = al1, out[3][i] = al2;
        for (int j = 0; j < 4; j++) {
            by[j][i] = i11 * d[j][0] + i12 * d[j][1];
            by[4 + j][i] = i12 * d[j][0] + i22 * d[j][1];
        }
        for (int j = 4; j < N; j++) {
            direct[j][0][i] = i11 * d[j][0] + i12 * d[j][1];
            direct[j][1][i] = i12 * d[j][0] + i22 * d[j][1];
        }
    }
}

static void slopes(row *by, row *point, row *direct, row *out) {
    OVER(WINDOWS) {
        double t1 = point[0][i], t2 = point[1][i], w1 = point[2][i], w2 = point[3][i];
        out[0][i] = w1, out[1][i] = w2;
        out[2][i] = by[0][i] * t1 + by[1][i] * t2 + by[2][i] * w1 + by[3][i] * w2 + direct[0][i];
        out[3][i] = by[4][i] * t1 + by[5][i] * t2 + by[6][i] * w1 + by[7][i] * w2 + direct[1][i];
    }
}

/* coefficients (7), starts (WINDOWS, 4), samples: the first of each step, and the place of each in its step; angles
 * (WINDOWS, samples, 2), derivatives (WINDOWS, samples, 2, N). */
void windows(const double *k, const double *starts, int steps, double h, const long *first, const double *place,
             int samples, double *angles, double *derivatives) {
    static row x[4], at[4], end[4], f[4], o[4], sum[4], by[8], direct[N][2];
    static row T[N][4], P[N][4], S[N][4], F[N][4], Z[N][4];
    memset(direct, 0, sizeof direct), memset(T, 0, sizeof T);
    for (int r = 0; r < 4; r++)
        for (int i = 0; i < WINDOWS; i++) x[r][i] = starts[4 * i + r], T[r][r][i] = 1;
    rates(k, x, f, by, direct);
    for (int d = 0; d < N; d++) slopes(by, T[d], direct[d], F[d]);
    for (int step = 0; step < steps; step++) {
        memcpy(o, f, sizeof o), memcpy(sum, f, sizeof sum), memcpy(S, F, sizeof S), memcpy(Z, F, sizeof Z);
        for (int stage = 1; stage < 4; stage++) {
            double offset = stage < 3 ? 0.5 * h : h, weight = stage < 3 ? 2 : 1;
            for (int r = 0; r < 4; r++) OVER(WINDOWS) at[r][i] = x[r][i] + offset * o[r][i];
            rates(k, at, o, by, direct);
            for (int r = 0; r < 4; r++) OVER(WINDOWS) sum[r][i] += weight * o[r][i];
            for (int d = 0; d < N; d++) {
                for (int r = 0; r < 4; r++) OVER(WINDOWS) P[d][r][i] = T[d][r][i] + offset * S[d][r][i];
                slopes(by, P[d], direct[d], S[d]);
                for (int r = 0; r < 4; r++) OVER(WINDOWS) Z[d][r][i] += weight * S[d][r][i];
            }
        }
        for (int r = 0; r < 4; r++) OVER(WINDOWS) end[r][i] = x[r][i] + h / 6 * sum[r][i];
        rates(k, end, o, by, direct);
        for (int d = 0; d < N; d++) {
            for (int r = 0; r < 4; r++) OVER(WINDOWS) P[d][r][i] = T[d][r][i] + h / 6 * Z[d][r][i];
            slopes(by, P[d], direct[d], S[d]);
        }
        for (long j = first[step]; j < first[step + 1]; j++) {
            double s = place[j], w0 = (1 + 2 * s) * (1 - s) * (1 - s), w1 = s * s * (3 - 2 * s);
            double w2 = h * s * (1 - s) * (1 - s), w3 = h * s * s * (s - 1);
            for (int i = 0; i < WINDOWS; i++)
                for (int r = 0; r < 2; r++) {
                    long place_of = ((long)i * samples + j) * 2 + r;
                    angles[place_of] = w0 * x[r][i] + w1 * end[r][i] + w2 * f[r][i] + w3 * o[r][i];
                    for (int d = 0; d < N; d++)
                        derivatives[place_of * N + d] =
                            w0 * T[d][r][i] + w1 * P[d][r][i] + w2 * F[d][r][i] + w3 * S[d][r][i];
                }
        }
        memcpy(x, end, sizeof x), memcpy(f, o, sizeof f), memcpy(T, P, sizeof T), memcpy(F, S, sizeof F);
    }
}
