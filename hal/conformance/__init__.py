"""What every backend of `hal` must do, as plain checks: one module an interface.

A module defines a bench (a protocol: the thing under test and the few handles that a check needs around
it) and `CHECKS`. Whoever writes a backend builds the bench and runs every check on a fresh one:

    from hal.conformance import spi

    @pytest.mark.parametrize("check", spi.CHECKS)
    def test_my_spi(check):
        check(MyBench())

A bench for real hardware needs a jumper or an echoing device; what it cannot offer (a card that can be
pulled out) it leaves None, and the checks of it pass over it. A check raises AssertionError.
"""
