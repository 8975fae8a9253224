"""A step of a body in flight in a frame that turns with it (docs/method.md section 1).

With c the centre of mass, r = x - c and w the rate of the frame, velocities are
``v = v_c + w x r + u``. In the frame the nodes bear, beside the elastic forces, the centrifugal
load -m w x (w x r) and Euler's -m a x r with I a = -w x I w, together without a torque, and the
Coriolis force, which turns u by -2 w dt and keeps its length. The solve finds u+, and the body is
taken along the arc that the frame describes::

    x+ = c+ + R (r + dt u+)      v+ = v_c+ + W x (x+ - c+) + R u+      R = exp(dt w)

W is the rate that gives the body its angular momentum at x+, so that this is kept to rounding. The
axis of w is that of I^-1 (L + R^T L), L seen from the body at both ends of the step: a turn about
it changes nothing of L . I^-1 L, so that a body that tumbles gains no energy, however far it turns
(the midpoint rule of Euler's equations).
"""
