! Runs LOWTRAN7 (subroutine LWTRN7) on the cards of TAPE5 and keeps full precision.
!
! Files, all in the working directory. In: TAPE5, a deck of cards for each leg, one after the other;
! JOBS, list-directed: first and last wavenumber and the number of paths, then for each path what is
! wanted and the number of its legs (decks). Out: out/TAPE6, out/TAPE7, out/TAPE8 of the last leg,
! which must exist before; RESULT, a stream of reals. FAILED names the leg that LOWTRAN7 gave up.
!
! What is wanted:
!   0  transmittance of all legs together: LWTRN7 fills the absorber amounts of each leg, these are
!      added, and the band functions of TRANS see the sum, as LOWTRAN7 itself does on its way from the
!      sun to the line of sight (label 115 of TRANS);
!   1  thermal radiance per micrometre that leaves the upper end of one rising leg, W cm-2 sr-1 um-1;
!   2  nothing: the deck is run as it is, for its TAPE7;
!   3  the model atmosphere: km, mb, K, g m-3 of water vapour, and ppmv of CO2, O3, N2O, CO, CH4 and O2
program run_lowtran7
  implicit none
  integer, parameter :: kmax = 63, none = 1
  real, parameter :: step = 5.0
  logical, parameter :: from_python = .false.

  real :: relhum(34), hstor(34), vh(17), tx(kmax), w(kmax), wpath(68, kmax), tbby(68)
  integer :: ich(4)
  common relhum, hstor, ich, vh, tx, w, wpath, tbby
  integer :: model, itype, iemsct, m1, m2, m3, im, noprt
  real :: tbound, salb
  common /card1/ model, itype, iemsct, m1, m2, m3, im, noprt, tbound, salb
  real :: v1, v2, dv
  common /card4/ v1, v2, dv
  integer :: kmx, m, ikmax, nl, ml, iklo, issgeo, imult
  common /cntrl/ kmx, m, ikmax, nl, ml, iklo, issgeo, imult
  real :: zm(34), pm(34), tm(34), rfndx(34), densty(kmax, 34), cldamt(34), rramt(34), eqlwc(34), hazec(34)
  common /model/ zm, pm, tm, rfndx, densty, cldamt, rramt, eqlwc, hazec
  real :: air(50, 10)  ! Z, P, T, WH, WCO2, WO, WN2O, WCO, WCH4, WO2
  common /mdata/ air
  real :: zp(35), pp(35), tp(35), rfndxp(35), sp(35), ppsum(35), tpsum(35), rhopsm(35)
  real :: denp(kmax, 35), amtp(kmax, 35)
  common /rfrpth/ zp, pp, tp, rfndxp, sp, ppsum, tpsum, rhopsm, denp, amtp

  real, allocatable :: total_tx(:, :), v(:), alam(:), trace(:), unif(:), suma(:), irrad(:, :), radiance(:)
  real :: first, last, one(none), gases(12)
  double precision :: total(kmax), humidity
  integer :: jobs, results, paths, path, legs, leg, wanted, count, level, failed

  one = 0.0
  gases = 0.0
  open (newunit=jobs, file='JOBS', status='old')
  open (newunit=results, file='RESULT', access='stream', form='unformatted', status='replace')
  read (jobs, *) first, last, paths
  count = nint((last - first) / step) + 1
  allocate (total_tx(count, kmax), v(count), alam(count), trace(count), unif(count), suma(count))
  allocate (irrad(count, 3), radiance(count))

  do path = 1, paths
    read (jobs, *) wanted, legs
    total = 0.0d0
    humidity = 0.0d0
    do leg = 1, legs
      if (path > 1 .or. leg > 1) call rewind_tapes()
      w = -1.0
      call run_deck()
      if (wanted < 2 .and. w(36) < 0.0) then  ! CO2 is on every path that was traced
        open (newunit=failed, file='FAILED', status='replace')
        write (failed, *) path, leg
        stop 3
      end if
      total = total + w
      ! LOWTRAN7 picks the spectral dependence of the boundary-layer aerosol by a mean of
      ! log(100 - relative humidity), weighted with the aerosol (labels 255 and 320 of GEO).
      if (w(7) > 0.0) humidity = humidity + w(7) * log(100.0d0 - w(15))
    end do
    select case (wanted)
    case (0)
      w = real(total)
      w(15) = 0.0
      if (total(7) > 0.0d0) w(15) = real(100.0d0 - exp(humidity / total(7)))
      call exabin()
      call spectrum()
      write (results) total_tx(:, 1)
    case (1)
      call turn_round()
      call spectrum()
      write (results) radiance
    case (3)
      write (results) (zm(level), air(level, 2:10), level=1, ml)
    end select
  end do

contains

  subroutine run_deck()
    call lwtrn7(from_python, count, first, last, step, total_tx, v, alam, trace, unif, suma, irrad, radiance, &
                0, 0, 0, 0, 0, none, 0, one, one, one, gases, 0.0, 0.0, 0.0, 0.0)
  end subroutine run_deck

  subroutine spectrum()
    v1 = first
    v2 = last
    dv = step
    call trans(0, 0, 0, 0.0, count, total_tx, v, alam, trace, unif, suma, irrad, radiance)
  end subroutine spectrum

  ! Amounts and temperatures of the layers in the order in which an observer above meets them. The path
  ! and its layers stay those of the transmittance; the sums over layers are those of GEO (label 265).
  subroutine turn_round()
    integer :: j, layer, k
    real :: so_far(kmax), warm
    so_far = 0.0
    do j = 1, ikmax
      layer = ikmax - j + 1
      tbby(j) = tpsum(layer) / rhopsm(layer)
      warm = min(max((296.0 - tbby(j)) / (296.0 - 260.0), 0.0), 1.0)
      do k = 1, kmax
        select case (k)
        case (9)
          so_far(k) = so_far(k) + warm * amtp(5, layer)
        case (59)
          so_far(k) = so_far(k) + amtp(8, layer) * 0.269 * (tbby(j) - 273.15)
        case (60)
          so_far(k) = so_far(k) + amtp(8, layer) * 0.269 * (tbby(j) - 273.15)**2
        case default
          so_far(k) = so_far(k) + amtp(k, layer)
        end select
        wpath(j, k) = so_far(k)
      end do
    end do
    tbound = 0.0
  end subroutine turn_round

  ! Keeps the listings of one leg only; without it they grow by 0.7 MB with each path.
  subroutine rewind_tapes()
    integer :: unit
    do unit = 16, 18
      rewind (unit)
    end do
  end subroutine rewind_tapes

end program run_lowtran7
