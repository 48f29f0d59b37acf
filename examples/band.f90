! BAND, a damper of a rocking wall, for a program in Fortran: copy `band_coefficient`.
!
!     gfortran -O2 -o band band.f90 && ./band
!
! prints the first peak under a half sine, 0.397, and x at tau = 4. Under restitution the first peak is 0.400.
module band
  implicit none
  integer, parameter :: dp = kind(1.0d0)
contains
  ! Return C [N s/m] at u [m] and v [m/s]; the damping force is C v.
  ! mass: m_eff [kg]; e: restitution; w1: circular frequency of the first branch [rad/s]; t_c: half-width [rad], 0.2.
  pure function band_coefficient(u, v, mass, e, w1, t_c) result(coefficient)
    real(dp), intent(in) :: u, v, mass, e, w1, t_c
    real(dp) :: coefficient, c, d, strength, r
    c = t_c/w1
    d = -log(e)
    strength = d*(1 + 0.4_dp*t_c**2 - 0.097_dp*t_c**4 - 0.043_dp*d**2)
    r = min(abs(u)/max(c*abs(v), 1.0e-90_dp), 1.0_dp)
    coefficient = mass*3*strength/(4*c)*(1 - r*r)
  end function

  ! A wall to check with, dimensionless: a1 = 0.04, b1 = 0.85, unit mass.
  pure function force(x) result(f)
    real(dp), intent(in) :: x
    real(dp) :: f
    f = sign(max(0.0_dp, min(0.85_dp, 0.85_dp/0.04_dp*abs(x), 1 - abs(x))), x)
  end function
end module

program check
  use band
  implicit none
  real(dp), parameter :: h = 0.002_dp  ! c/22
  real(dp) :: x = 0, v = 0, a = 0, peak = 0, p, c, half, expected, w1
  integer :: n
  w1 = sqrt(0.85_dp/0.04_dp)
  do n = 1, 2000
    p = 0
    if (n < 350) p = 2*sin(acos(-1.0_dp)*n/350)  ! 2 F0 for 0.7 in tau
    half = v + h/2*a
    expected = v + h*a
    x = x + h*v + h*h/2*a
    c = band_coefficient(x, expected, 1.0_dp, 0.85_dp, w1, 0.2_dp)  ! at the end of the step
    a = (p - force(x) - c*half)/(1 + c*h/2)
    v = half + h/2*a
    if (n < 1000) peak = max(peak, x)
  end do
  print '(2f19.15)', peak, x
end program
