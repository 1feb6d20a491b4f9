/* The modal bank of dsp/bank.py as plain C, to measure the compiled Python against: same form, same precision. */

enum { LANES = 8, MOMENTS = 8, FINE = 14, QUANTUM = 64, RESPONSES = (2 * FINE + 8) * LANES };

typedef const double *restrict in;
typedef double *restrict inout;

static inline void ring(long n, inout y1, inout y2, in a1, in a2, in balance, inout out)
{
    double *l = out, *r = out + QUANTUM;
    for (long t = 0; t < QUANTUM; t += 4) {
        double l0 = 0, l1 = 0, l2 = 0, l3 = 0, r0 = 0, r1 = 0, r2 = 0, r3 = 0;
        for (long i = 0; i < n; i++) {
            double u = y1[i], v = y2[i];
            v = a1[i] * u + a2[i] * v;
            l0 += v;
            r0 += balance[i] * v;
            u = a1[i] * v + a2[i] * u;
            l1 += u;
            r1 += balance[i] * u;
            v = a1[i] * u + a2[i] * v;
            l2 += v;
            r2 += balance[i] * v;
            u = a1[i] * v + a2[i] * u;
            l3 += u;
            r3 += balance[i] * u;
            y1[i] = u;
            y2[i] = v;
        }
        l[t] = l0, l[t + 1] = l1, l[t + 2] = l2, l[t + 3] = l3;
        r[t] = r0, r[t + 1] = r1, r[t + 2] = r2, r[t + 3] = r3;
    }
}

static inline void ring_frame(long n, inout y1, inout y2, in a1, in a2, in balance, inout out)
{
    double l = 0, r = 0;
    for (long i = 0; i < n; i++) {
        double v = a1[i] * y1[i] + a2[i] * y2[i];
        y2[i] = y1[i];
        y1[i] = v;
        l += v;
        r += balance[i] * v;
    }
    out[0] = l;
    out[QUANTUM] = r;
}

/* By hand: from loops, GCC makes code of half this speed. */
typedef double lanes __attribute__((vector_size(64), aligned(8), may_alias));
typedef float float_lanes __attribute__((vector_size(32), aligned(4), may_alias));

static inline void inject(long n, inout y1, inout y2, in response, const float *restrict shape, in weights, in moments)
{
    for (long first = 0; first < n; first += LANES) {
        const lanes *h = (const lanes *)(response + first / LANES * RESPONSES);
        lanes phi = {0}, now = {0}, last = {0};
        for (long k = 0; k < 4; k++)
            phi += weights[k] * __builtin_convertvector(*(const float_lanes *)(shape + k * n + first), lanes);
        for (long k = 0; k < MOMENTS; k++) {
            now += moments[k] * h[2 * k];
            last += moments[k] * h[2 * k + 1];
        }
        *(lanes *)(y1 + first) += phi * now;
        *(lanes *)(y2 + first) += phi * last;
    }
}

void ring_quanta(long objects, long n, long quanta, double *y1, double *y2, double *a1, double *a2, double *balance,
                 double *out)
{
    for (long q = 0; q < quanta; q++)
        for (long i = 0; i < objects * n; i += n)
            ring(n, y1 + i, y2 + i, a1 + i, a2 + i, balance + i, out);
}

void drive_quanta(long objects, long n, long quanta, double *y1, double *y2, double *a1, double *a2, double *balance,
                  double *out, double *response, float *shape, double *weights, double *moments)
{
    for (long q = 0; q < quanta; q++)
        for (long i = 0; i < objects * n; i += n)
            for (long t = 0; t < QUANTUM; t++) {
                inject(n, y1 + i, y2 + i, response + i / LANES * RESPONSES, shape + 4 * i, weights, moments);
                ring_frame(n, y1 + i, y2 + i, a1 + i, a2 + i, balance + i, out + t);
            }
}
