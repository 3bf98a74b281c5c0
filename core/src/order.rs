//! Ordering index lists in place: ascending sort, and k-th smallest under a key.
//!
//! Written out because the standard library's versions keep a panic path (a comparison that contradicts itself) that
//! would end up in the firmware. Neither algorithm's internal order reaches a result: callers see a sorted list of
//! distinct indices, or a partition that only prunes a search.

/// Stretches of a list that are no longer than this are sorted by insertion.
const SHORT: usize = 12;

/// A stretch `low..high` of a list whose members agree in all bits above `bits`.
#[derive(Clone, Copy)]
struct Stretch {
    low: usize,
    high: usize,
    bits: u32,
}

/// Sorts indices, ascending. Binary radix exchange: the members with a 0 in the highest bit go before those with a 1, and so
/// on within both parts, down to short stretches. `O(16 n)` at worst, whatever the list, and without comparing two members
/// it looks at each of them a few times only: a quarter of heapsort's work on neighbourhoods of some hundred points.
pub(crate) fn sort(list: &mut [u16]) {
    // Waiting parts: one a bit at most.
    let mut pending = heapless::Vec::<Stretch, 17>::new();
    let first = list.first().copied().unwrap_or(0);
    let differing = list.iter().fold(0, |differing, &index| differing | (index ^ first));
    let _ = pending.push(Stretch { low: 0, high: list.len(), bits: u16::BITS - differing.leading_zeros() });
    while let Some(Stretch { low, high, bits }) = pending.pop() {
        let Some(part) = list.get_mut(low..high) else { return };
        if part.len() <= SHORT || bits == 0 {
            insert(part);
            continue;
        }
        let bit = 1_u16 << (bits - 1);
        let zeros = zeros_first(part, bit);
        for (low, high) in [(low, low + zeros), (low + zeros, high)] {
            // Never full: the second of the two is taken up at once, so that one waits for each bit.
            let _ = pending.push(Stretch { low, high, bits: bits - 1 });
        }
    }
}

/// Moves the members without the bit before those with it; returns how many are without.
fn zeros_first(part: &mut [u16], bit: u16) -> usize {
    let mut zeros = 0;
    for place in 0..part.len() {
        // Written always and counted when it is a zero: no branch that the data decides.
        let (Some(&here), Some(&first_one)) = (part.get(place), part.get(zeros)) else { return zeros };
        if let Some(slot) = part.get_mut(place) {
            *slot = if here & bit == 0 { first_one } else { here };
        }
        if let Some(slot) = part.get_mut(zeros) {
            *slot = if here & bit == 0 { here } else { first_one };
        }
        zeros += usize::from(here & bit == 0);
    }
    zeros
}

/// Sorts a short list by insertion.
fn insert(part: &mut [u16]) {
    for place in 1..part.len() {
        let Some(&new) = part.get(place) else { return };
        let mut hole = place;
        while hole > 0
            && let Some(&before) = part.get(hole - 1)
            && before > new
        {
            if let Some(slot) = part.get_mut(hole) {
                *slot = before;
            }
            hole -= 1;
        }
        if let Some(slot) = part.get_mut(hole) {
            *slot = new;
        }
    }
}

/// Sorts ascending by `key` (heapsort: in place, `O(n log n)` whatever the input). Keys must be totally ordered.
fn sort_by_key<K: PartialOrd>(list: &mut [u16], key: impl Fn(u16) -> K) {
    let n = list.len();
    for root in (0..n / 2).rev() {
        sift_down(list, root, n, &key);
    }
    for end in (1..n).rev() {
        swap(list, 0, end);
        sift_down(list, 0, end, &key);
    }
}

/// Restores the max-heap below `root` within `list[..end]`.
fn sift_down<K: PartialOrd>(list: &mut [u16], mut root: usize, end: usize, key: &impl Fn(u16) -> K) {
    let Some(heap) = list.get_mut(..end) else { return };
    loop {
        let left = 2 * root + 1;
        let (Some(&parent), Some(&first)) = (heap.get(root), heap.get(left)) else { return };
        let mut child = left;
        let mut largest = first;
        if let Some(&second) = heap.get(left + 1)
            && key(second) > key(first)
        {
            child = left + 1;
            largest = second;
        }
        if key(largest) <= key(parent) {
            return;
        }
        swap(heap, root, child);
        root = child;
    }
}

/// Puts the element of rank `k` at position `k`, keys not larger before it and not smaller behind it.
///
/// Quickselect after Hoare with the median of three; after `2 log2 n` partitions that did not finish it sorts what is
/// left, so the work is `O(n log n)` at worst and `O(n)` as a rule.
pub(crate) fn select_by_key<K: PartialOrd + Copy>(list: &mut [u16], k: usize, key: impl Fn(u16) -> K) {
    let (mut low, mut high) = (0, list.len());
    let mut partitions = 2 * (usize::BITS - list.len().leading_zeros());
    while let Some(part) = list.get_mut(low..high)
        && part.len() > 1
    {
        if partitions == 0 {
            sort_by_key(part, &key);
            return;
        }
        partitions -= 1;
        let Some(pivot) = median_of_three(part, &key) else { return };
        let (below, above) = partition(part, &pivot, &key);
        if k < low + below {
            high = low + below;
        } else if k >= low + above {
            low += above;
        } else {
            return;
        }
    }
}

/// Hoare's partition about a key that occurs in the part: returns `(below, above)` such that `part[..below]` is not
/// larger than the pivot, `part[above..]` not smaller, and what is between equals it.
fn partition<K: PartialOrd>(part: &mut [u16], pivot: &K, key: &impl Fn(u16) -> K) -> (usize, usize) {
    // `right` is one past the element under inspection, so that it can reach the front.
    let (mut left, mut right) = (0, part.len());
    loop {
        while part.get(left).is_some_and(|&index| key(index) < *pivot) {
            left += 1;
        }
        while right > 0 && part.get(right - 1).is_some_and(|&index| key(index) > *pivot) {
            right -= 1;
        }
        if left >= right {
            return (right, left);
        }
        swap(part, left, right - 1);
        left += 1;
        right -= 1;
        if left > right {
            return (right, left);
        }
    }
}

/// Exchanges two elements; an index out of range changes nothing (`slice::swap` would keep a panic).
fn swap(list: &mut [u16], i: usize, j: usize) {
    if let (Some(&a), Some(&b)) = (list.get(i), list.get(j)) {
        if let Some(slot) = list.get_mut(i) {
            *slot = b;
        }
        if let Some(slot) = list.get_mut(j) {
            *slot = a;
        }
    }
}

fn median_of_three<K: PartialOrd + Copy>(part: &[u16], key: &impl Fn(u16) -> K) -> Option<K> {
    let a = key(*part.first()?);
    let b = key(*part.get(part.len() / 2)?);
    let c = key(*part.last()?);
    Some(if a < b {
        if b < c {
            b
        } else if a < c {
            c
        } else {
            a
        }
    } else if a < c {
        a
    } else if b < c {
        c
    } else {
        b
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    #[test]
    fn any_list_is_sorted() {
        let mut stream = Stream::new(3);
        for length in 0..60 {
            let mut list = [0_u16; 64];
            let list = &mut list[..length];
            assert!(stream.sample(1000, list));
            let mut other = [0_u16; 64];
            let other = &mut other[..length];
            other.copy_from_slice(list);
            sort_by_key(list, |index| index);
            assert!(list.windows(2).all(|pair| pair[0] < pair[1]), "{list:?}");
            sort(other);
            assert_eq!(list, other);
        }
    }

    #[test]
    fn long_lists_of_every_kind_are_sorted() {
        let mut stream = Stream::new(5);
        for highest in [1, 2, 7, 1000, 65_536] {
            let mut list: [u16; 3000] = core::array::from_fn(|_| stream.below(highest) as u16);
            let mut expected = list;
            expected.sort_unstable();
            sort(&mut list);
            assert_eq!(list, expected, "below {highest}");
            list.reverse();
            sort(&mut list);
            assert_eq!(list, expected, "below {highest}, downwards");
        }
        sort(&mut [u16::MAX; 40]);
    }

    #[test]
    fn every_rank_is_selected() {
        let mut stream = Stream::new(4);
        for round in 0..2000 {
            let length = 1 + (round % 60);
            let mut list = [0_u16; 64];
            let list = &mut list[..length];
            assert!(stream.sample(if round % 2 == 0 { 64 } else { 60_000 }, list));
            let k = stream.below(length as u32) as usize;
            select_by_key(list, k, |index| (index / 7, index));
            let middle = list[k];
            assert!(list[..k].iter().all(|&other| other < middle), "{k} {list:?}");
            assert!(list[k + 1..].iter().all(|&other| other > middle), "{k} {list:?}");
        }
    }

    #[test]
    fn ordered_input_is_no_trap() {
        let mut up: [u16; 1000] = core::array::from_fn(|k| k as u16);
        select_by_key(&mut up, 500, |index| index);
        assert_eq!(up[500], 500);
        let mut down: [u16; 1000] = core::array::from_fn(|k| 999 - k as u16);
        select_by_key(&mut down, 10, |index| index);
        assert_eq!(down[10], 10);
    }
}
