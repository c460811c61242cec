"""What is asked for again of the very same arguments is not made twice, and of equal ones it is."""

from stribeck.model.asked import asked_once


class Counted:
    def __init__(self) -> None:
        self.made = 0

    @asked_once
    def sum(self, values: list[float], *, more: float = 0.0, less: float = 0.0) -> list[float]:
        self.made += 1
        return [sum(values) + more - less]


def test_the_very_same_arguments_give_what_they_gave() -> None:
    counted, values = Counted(), [1.0, 2.0]
    assert counted.sum(values) is counted.sum(values)
    assert counted.made == 1
    assert counted.sum([1.0, 2.0]) == counted.sum(values)  # another object that is equal now need not stay so
    assert counted.made == 2


def test_other_arguments_and_other_objects_have_their_own() -> None:
    counted, values, more = Counted(), [1.0], 1.0
    assert counted.sum(values, more=more) == [2.0]
    assert counted.sum(values, less=more) == [0.0]
    assert counted.sum(values) == [1.0]
    assert Counted().sum(values) is not counted.sum(values)


def test_what_was_asked_with_is_kept_so_that_nothing_takes_its_place_in_memory() -> None:
    counted = Counted()
    found = [counted.sum([float(k)])[0] for k in range(100)]
    assert found == [float(k) for k in range(100)]
