/* The loops around equations that CasADi wrote: `rhs` takes the state, SIZE numbers, to its rate of change. */
#include "casadi_rhs.h"

typedef struct {
    double none; /* the parameters are in the generated code */
} Crane;

static inline void derivative(const Crane *p, const double *x, double *dx)
{
    const double *inputs[1] = {x};
    double *outputs[1] = {dx};
    (void)p;
    rhs(inputs, outputs, 0, 0, 0);
}

#include "loop.h"
