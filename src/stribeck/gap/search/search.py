"""The search: forward from what every arm has, then each effect is tried without."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial

from stribeck.effects.placing import stated_effects
from stribeck.gap.fitted.clocks import in_step_beside
from stribeck.gap.fitted.model import Model, referred, retune
from stribeck.gap.records.prepare import Prepared
from stribeck.gap.search.beside import idle, misleading, stands_in, weighed, with_together, without_each
from stribeck.gap.search.each_joint import with_lags
from stribeck.gap.search.forward import forward, hardly
from stribeck.gap.search.instead import SURELY, Instead, instead, outdone, with_as_good
from stribeck.gap.search.lengths import of_asked_lengths
from stribeck.gap.search.look_alike import with_look_alikes
from stribeck.gap.search.ordinary import is_ordinary, ordinary, retuned_with
from stribeck.gap.search.other_ways import another_way, passed_over
from stribeck.gap.search.pool import Pool
from stribeck.gap.search.presence import evidence, presence
from stribeck.gap.search.rank import rank
from stribeck.gap.search.setting import Asked, Known, Setting
from stribeck.gap.search.step import Step, last_model
from stribeck.gap.search.swap import swapped
from stribeck.gap.search.tuned import Retuned, asks_for_lower, in_lower_band, lies_above
from stribeck.model.layout import Placed
from stribeck.model.scale import Scale

FREELY, LIKELY = 3, 0.5  # effects that are kept whatever they are worth, and how likely a further one must be
MOST_NEEDLESS = 3  # searches made anew without an effect that is needless beside the others
MOST_ROUNDS = 4  # of a search that starts anew from a model with more of what every arm has


def search(tuned: Retuned, asked: Asked) -> tuple[Retuned, tuple[Step, ...]]:
    """Return the recordings, as the re-tuned model is compared by them, and the steps of the search from there.

    Forward first, from a model that is re-tuned with what every arm has, where that is found; and once more where what
    was taken leaves little but the encoder's noise in the upper part of the band, by a lower one, unless it then lies
    above that. Then each effect is tried without: what it is worth beside the others. One that was taken for the sake
    of a later one (masking) is not needed any more, and the search is made again without it; so it is where the only
    one leaves much that nothing closes, and where links of other lengths do what one of them does.

    Parameters
    ----------
    tuned : Retuned
        What encoder noise and filters leave on the held-out runs is its floor; noise in the torque is added to it.
    asked : Asked
    """
    with Pool(asked.jobs) as pool:
        tuned, setting, base, found = _forward_by_the_band(tuned, asked, pool)
        steps, without = _believed(setting, found)
        other = another_way(setting, base, steps)
        if other is not steps:
            steps, without = _believed(setting, other)
        setting, steps, without, others = _without_the_needless(setting, base, steps, without)
        prepared, seed = setting.prepared, setting.seed
        longer = of_asked_lengths(replace(tuned, prepared=prepared), without, steps[-1].floor, asked)
        if longer is not None:
            return search(longer, asked)
        steps = with_as_good(prepared, steps, without, others, seed)
        steps = with_lags(prepared, steps, without, pool, seed, setting.leave_out)
        steps = with_together(prepared, steps, pool, seed)
        return replace(tuned, prepared=prepared), with_look_alikes(prepared, steps, without, pool, seed)


def _forward_by_the_band(tuned: Retuned, asked: Asked, pool: Pool) -> tuple[Retuned, Setting, Model, tuple[Step, ...]]:
    """Return a forward search by the band that suits it, with the clocks of the runs set beside what it found."""
    setting = _setting(tuned, asked, pool)
    setting, base, found, first = _from_the_ordinary(setting, tuned.base, until=asks_for_lower)
    while lower := in_lower_band(replace(tuned, prepared=setting.prepared), last_model(found), asked):
        asked.progress("again, by a band with less of the encoder's noise")
        same = [step for step in first if step.taken]
        below, lower_base, rest, again = _from_the_ordinary(
            _setting(lower, asked, pool), lower.base, same, until=asks_for_lower
        )
        if lies_above(setting.prepared, found, lower.prepared, rest):  # by this band, then, to the end
            setting, base, found, _ = _from_the_ordinary(_setting(tuned, asked, pool), tuned.base, same)
            break
        tuned, setting, base, found, first = lower, below, lower_base, rest, again
    told = in_step_beside(setting.prepared, last_model(found))
    if told is not setting.prepared:
        asked.progress("again, with the clocks of the runs set anew")
        setting = replace(setting, prepared=referred(told, tuned.base), anew=False)
        setting, base, found, _ = _from_the_ordinary(setting, tuned.base)
    return tuned, setting, base, found


def _without_the_needless(
    setting: Setting, base: Model, steps: tuple[Step, ...], without: list[Model]
) -> tuple[Setting, tuple[Step, ...], list[Model], list[Instead]]:
    """Return a search that is made again as long as it takes what is needless beside the rest, with its rivals there.

    ``without`` is the last model without each effect.
    """

    def rivals(gone: Sequence[Placed] = ()) -> list[Instead]:
        found = instead(setting.prepared, steps, setting.pool, setting.leave_out, gone)
        return found + swapped(setting, steps, without)

    unneeded, others, gone = idle(steps), rivals(), list[Placed]()
    needless = unneeded.key if unneeded else outdone(setting.prepared, steps, others, setting.seed) or misleading(steps)
    for _ in range(MOST_NEEDLESS):
        if needless is None:
            break
        setting.progress(f"again without {needless[0]}")
        for barring, other in _ways_without(needless, setting, base, steps, unneeded=bool(unneeded)):
            ranking = rank(setting.prepared, [last_model(steps), last_model(other)], steps[-1].floor, setting.seed)
            better = ranking.overall[1] > -unneeded.cost if unneeded else ranking.probability[1] > SURELY
            if not better:
                continue
            gone += [place for place in last_model(steps).placed if place.key == needless]
            setting = barring
            steps, without = _believed(setting, other)
            others = rivals(gone)
            unneeded = idle(steps)  # what came in its place may be needless in turn
            needless = unneeded.key if unneeded else None
            break
        else:
            break
    return setting, steps, without, others


def _ways_without(
    needless: tuple[str, int], setting: Setting, base: Model, steps: tuple[Step, ...], *, unneeded: bool
) -> Iterator[tuple[Setting, tuple[Step, ...]]]:
    """Yield searches without an effect: anew, and where it has become needless also with what came after it first."""
    anew = replace(setting, barred=setting.barred | {needless}, anew=False)
    barring, _, other, _ = _from_the_ordinary(anew, base)
    yield barring, other
    if unneeded:
        other = passed_over(anew, base, steps, needless)
        if other is not steps:
            yield anew, other


def _setting(tuned: Retuned, asked: Asked, pool: Pool) -> Setting:
    prepared = referred(tuned.prepared, tuned.base)
    stated = sum(not place.effect.direct for place in stated_effects(prepared.arm))
    nothing: frozenset[tuple[str, int]] = frozenset()
    return Setting(prepared, tuned.noise.rms, asked.seed, pool, asked.leave_out, nothing, asked.progress, stated)


def _believed(setting: Setting, steps: tuple[Step, ...]) -> tuple[tuple[Step, ...], list[Model]]:
    """Return the steps with what each effect is worth, without a last one that is hardly there beside the others.

    Nor one that stands in for another: beside what does the same work as well, an effect is worth little. Nor beyond
    the third one that is not likely: what is left of a law that nobody knows is made up of any number of others. With
    the steps, the last model without each effect.
    """
    steps, without = _weighed(setting, steps)
    while _one_too_many(steps):  # as if it had not been tried: what follows the noise there would lower its floor
        steps, without = _weighed(setting, steps[: sum(step.taken for step in steps) - 1])
    taken = [step for step in steps if step.taken]
    if len(taken) > 1 and (hardly(taken[-1]) or stands_in(taken)):
        given_up = replace(steps[len(taken) - 1], passing=(), worth=None)
        steps, without = _weighed(setting, (*steps[: len(taken) - 1], given_up))
    return steps, without


def _weighed(setting: Setting, steps: tuple[Step, ...]) -> tuple[tuple[Step, ...], list[Model]]:
    without = without_each(setting.prepared, steps, setting.pool)
    return weighed(setting.prepared, steps, without, setting.seed), without


def _one_too_many(steps: Sequence[Step]) -> bool:
    """Return whether the last effect that was taken comes after three others, and is not likely to be there."""
    taken = [step for step in steps if step.taken]
    names = {step.best.placed[-1].effect.name for step in taken if step.best is not None}
    return len(names) > FREELY and presence(evidence(taken[-1])) < LIKELY


def _from_the_ordinary(
    setting: Setting,
    base: Model,
    same: Sequence[Step] = (),
    until: Callable[[Prepared, Model], bool] = lambda prepared, model: False,
) -> tuple[Setting, Model, tuple[Step, ...], tuple[Step, ...]]:
    """Return the first steps of a search that starts anew, re-tuned with what every arm has, where it finds that.

    The rivals of the ``same`` steps, those of a search by another band, will do while they come to the same. The first
    model of which ``until`` is true ends it, to be made in another way. With them, the steps that were made before
    anything was re-tuned along.
    """
    prepared, scales = setting.prepared, setting.prepared.scales
    known: Known = {}
    steps = forward(setting, base, known, same=same, until=partial(until, prepared))
    if until(prepared, last_model(steps)):
        return setting, base, steps, steps
    grown = {place.key for place in _grown(setting, base, steps)}
    if grown:
        base = retune(setting.prepared, setting.floor, [place for place in base.placed if place.key not in grown])
        setting = replace(setting, prepared=referred(setting.prepared, base))
        steps = forward(setting, base, known)
    first = steps
    for _ in range(MOST_ROUNDS):
        if not ordinary(steps, scales):
            return setting, base, steps, first
        setting.progress("again, re-tuned with what every arm has")
        for again in retuned_with(setting.prepared, setting.floor, base, setting.stated, steps, setting.seed):
            anew, start = replace(setting, prepared=referred(setting.prepared, again), anew=True), dict(known)
            further = forward(anew, again, start, same=_before_the_ordinary(steps, scales))
            if not _grown(anew, again, further):
                break
        else:
            break
        setting, base, steps, known = anew, again, further, start
    goes_on = steps[-1].taken and ordinary(steps, scales)
    return setting, base, forward(setting, base, known, steps) if goes_on else steps, first


def _grown(setting: Setting, base: Model, steps: Sequence[Step]) -> list[Placed]:
    """Return what a base was re-tuned with that is more than every arm has beside what was found: it may be a cause."""
    ends = last_model(steps).placed[setting.stated : len(base.placed)]
    return [place for place in ends if not is_ordinary(place, setting.prepared.scales)]


def _before_the_ordinary(steps: Sequence[Step], scales: Sequence[Scale]) -> list[Step]:
    """Return the steps that took effects of a size before the first of what every arm has."""
    taken = last_model(steps).placed[len(steps[0].base.placed) :]
    common = [is_ordinary(place, scales) for place in taken]
    return list(steps[: common.index(True)])
