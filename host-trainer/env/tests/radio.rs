//! The channel model through its public interface: what it does to datagrams, how often, and
//! that nothing but the seed and the datagrams themselves decides it.

use covey_env::radio::{DatagramCounts, MAX_NODES, RadioChannel, RadioError, RadioSettings};
use proptest::prelude::*;
use std::collections::BTreeMap;

fn settings(text: &str) -> RadioSettings {
    text.parse().expect("valid settings")
}

fn channel(text: &str, nodes: usize, seed: u64) -> RadioChannel {
    RadioChannel::new(&settings(text), nodes, seed).expect("valid settings")
}

/// Everything that has arrived at `to`: time, sender, bytes.
fn drain(channel: &mut RadioChannel, now_ms: u64, to: usize) -> Vec<(u64, usize, Vec<u8>)> {
    let mut out = Vec::new();
    while let Some(d) = channel.poll(now_ms, to) {
        out.push((d.due_ms, d.from, d.bytes.to_vec()));
    }
    out
}

/// The numbers of the datagrams that arrive of `n` sent from 0 to 1, `gap_ms` apart, in the
/// order of their arrival.
fn arrivals(channel: &mut RadioChannel, n: u32, gap_ms: u64) -> Vec<u32> {
    for k in 0..n {
        channel.send(u64::from(k) * gap_ms, 0, 1, &k.to_le_bytes());
    }
    let number = |bytes: Vec<u8>| u32::from_le_bytes(bytes.try_into().expect("four bytes"));
    drain(channel, u64::MAX, 1).into_iter().map(|(_, _, bytes)| number(bytes)).collect()
}

/// The lengths of the gaps in ascending numbers 0..n.
fn bursts(arrived: &[u32], n: u32) -> Vec<u32> {
    let ends = arrived.iter().map(|&k| k as i64).chain([i64::from(n)]);
    let begins = [-1].into_iter().chain(arrived.iter().map(|&k| k as i64));
    ends.zip(begins).map(|(end, begin)| (end - begin - 1) as u32).filter(|&l| l > 0).collect()
}

#[test]
fn a_perfect_channel_delivers_everything_at_once_and_in_order() {
    let mut r = channel("perfect", 3, 1);
    r.broadcast(5, 1, b"hello");
    r.send(5, 0, 2, b"you");
    assert_eq!((r.next_due_ms(2), r.poll(4, 2)), (Some(5), None));
    let hello = |from| (5, from, b"hello".to_vec());
    assert_eq!(drain(&mut r, 5, 2), [(5, 0, b"you".to_vec()), hello(1)]);
    assert_eq!(drain(&mut r, 5, 0), [hello(1)]);
    assert_eq!((drain(&mut r, 5, 1), r.in_flight()), (vec![], 0));
    assert_eq!(r.counts(), DatagramCounts { sent: 3, delivered: 3, ..DatagramCounts::default() });
    assert_eq!(arrivals(&mut r, 100, 0), (0..100).collect::<Vec<_>>());
}

/// Figures that must never change: recorded flights would.
#[test]
fn a_seed_has_its_own_exact_losses() {
    let lost = |text: &str| {
        let mut r = channel(text, 2, 7);
        let arrived = arrivals(&mut r, 40, 1);
        (0..40).filter(|k| !arrived.contains(k)).collect::<Vec<u32>>()
    };
    assert_eq!(lost("loss=0.3"), [0, 9, 14, 18, 21, 23, 26, 29, 35, 36, 38, 39]);
    assert_eq!(lost("loss=0.3,burst=4"), [0, 9, 10, 36, 39]);
}

#[test]
fn losses_come_as_often_as_they_should_one_by_one_or_in_bursts() {
    const N: u32 = 50_000;
    for (loss, burst) in
        [(0.1, None), (0.5, None), (0.1, Some(3.0)), (0.3, Some(1.43)), (0.3, Some(8.0)), (0.5, Some(2.0))]
    {
        let settings = RadioSettings { loss, burst, ..RadioSettings::default() };
        let mut r = RadioChannel::new(&settings, 2, 11).unwrap();
        let arrived = arrivals(&mut r, N, 1);
        let share = 1.0 - arrived.len() as f64 / f64::from(N);
        let lengths = bursts(&arrived, N);
        let mean = f64::from(lengths.iter().sum::<u32>()) / lengths.len() as f64;
        let expected = burst.unwrap_or(1.0 / (1.0 - loss));
        // Bursts make shares and means less certain.
        let error = (loss * expected * 2.0 / f64::from(N)).sqrt();
        assert!((share - loss).abs() < 4.0 * error, "{settings}: {share} lost");
        assert!((mean / expected - 1.0).abs() < 0.06, "{settings}: {mean} in a row");
    }
}

#[test]
fn jitter_is_uniform_and_lets_one_overtake_another() {
    let mut r = channel("delay_ms=100,jitter_ms=9", 2, 3);
    for _ in 0..10_000 {
        r.send(1_000, 0, 1, b"x");
    }
    let mut counted = [0u32; 10];
    drain(&mut r, 2_000, 1).iter().for_each(|(due, _, _)| counted[(due - 1_100) as usize] += 1);
    assert!(counted.iter().all(|s| s.abs_diff(1_000) < 150), "{counted:?}");
    let order = arrivals(&mut r, 100, 1);
    assert!(!order.is_sorted() && order.len() == 100, "{order:?}");
}

#[test]
fn a_datagram_held_back_comes_right_behind_the_next_one() {
    let mut r = channel("reorder=1", 2, 3);
    // At most one is held, so they come in swapped pairs; the last one has none behind it.
    assert_eq!(arrivals(&mut r, 7, 10), [1, 0, 3, 2, 5, 4]);
    assert_eq!((r.in_flight(), r.counts().held, r.next_due_ms(1)), (1, 4, None));
    r.send(1_000, 0, 1, &7u32.to_le_bytes());
    let late: Vec<_> = drain(&mut r, 1_000, 1).into_iter().map(|(due, _, bytes)| (due, bytes[0])).collect();
    assert_eq!(late, [(1_000, 7), (1_000, 6)]);
}

#[test]
fn a_range_ends_the_radio_where_both_places_are_known() {
    let mut r = channel("range_u=34", 3, 3);
    r.set_position(0, (100.0, 100.0));
    r.set_position(1, (134.0, 100.0));
    r.broadcast(0, 0, b"x");
    r.set_position(1, (134.0, 100.1));
    r.broadcast(0, 0, b"y");
    let received = |r: &mut RadioChannel, to| drain(r, 0, to).into_iter().map(|(_, _, b)| b[0]).collect::<Vec<_>>();
    assert_eq!((received(&mut r, 1), received(&mut r, 2)), (vec![b'x'], vec![b'x', b'y']));
    assert_eq!(r.counts().out_of_range, 1);
}

#[test]
fn corruption_flips_one_to_four_bits_of_a_copy() {
    let mut r = channel("corrupt=1,duplicate=1", 2, 3);
    let original = [0x5a; 27];
    (0..2_000).for_each(|_| r.send(0, 0, 1, &original));
    let mut counted = BTreeMap::<u32, u32>::new();
    for (_, _, bytes) in drain(&mut r, 0, 1) {
        assert_eq!(bytes.len(), original.len());
        let flipped = bytes.iter().zip(&original).map(|(a, b)| (a ^ b).count_ones()).sum();
        *counted.entry(flipped).or_default() += 1;
    }
    assert_eq!(counted.keys().copied().collect::<Vec<_>>(), [1, 2, 3, 4]);
    assert!(counted.values().all(|n| n.abs_diff(1_000) < 150), "{counted:?}");
    assert_eq!(r.counts().corrupted, 4_000);
    // Nothing to flip, and fewer bits than flips.
    r.send(0, 0, 1, b"");
    assert_eq!(r.poll(0, 1).map(|d| d.bytes.len()), Some(0));
}

#[test]
fn settings_out_of_range_are_refused() {
    let refused = |settings: &RadioSettings, nodes| RadioChannel::new(settings, nodes, 0).unwrap_err();
    let default = RadioSettings::default();
    assert_eq!(refused(&default, 0), RadioError::Nodes(0));
    assert_eq!(refused(&default, MAX_NODES + 1), RadioError::Nodes(MAX_NODES + 1));
    let bad = RadioSettings { loss: 1.1, ..default };
    assert_eq!(refused(&bad, 2), RadioError::Probability { key: "loss", value: 1.1 });
}

fn any_settings() -> impl Strategy<Value = RadioSettings> {
    let share = || prop_oneof![Just(0.0), 0.0f64..=1.0];
    let burst = prop::option::of(0.0f64..20.0);
    (share(), burst, 0u32..3_000, 0u32..3_000, share(), share(), share(), prop::option::of(1.0f32..200.0)).prop_map(
        |(loss, extra, delay_ms, jitter_ms, duplicate, reorder, corrupt, range_u)| {
            let least = if loss < 1.0 { 1.0 / (1.0 - loss) } else { 1.0 };
            let burst = extra.map(|e| least + e);
            RadioSettings { loss, burst, delay_ms, jitter_ms, duplicate, reorder, corrupt, range_u }
        },
    )
}

/// Who sends to whom, how long after the one before, and how much.
fn traffic() -> impl Strategy<Value = Vec<(usize, usize, u64, u8)>> {
    prop::collection::vec((0usize..5, 0usize..5, 0u64..300, any::<u8>()), 0..300)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Each datagram is accounted for, none comes early, none to another, and each is intact
    /// where nothing corrupts it.
    #[test]
    fn what_is_sent_arrives_is_lost_or_is_on_its_way(settings in any_settings(), seed: u64, traffic in traffic()) {
        let mut r = RadioChannel::new(&settings, 5, seed).unwrap();
        (0..5).for_each(|i| r.set_position(i, (40.0 * i as f32, 0.0)));
        let (mut now, mut arrived) = (0, 0);
        let mut sent = Vec::new();
        for (k, &(from, to, gap, fill)) in traffic.iter().enumerate() {
            now += gap;
            let bytes = [&(k as u32).to_le_bytes()[..], &[fill; 20]].concat();
            r.send(now, from, to, &bytes);
            sent.push((now, from, to, bytes));
            if k % 7 == 0 {
                arrived += drain(&mut r, now, to).len();
            }
        }
        let last = now + u64::from(settings.delay_ms + settings.jitter_ms);
        for to in 0..5 {
            let mut before = 0;
            for (due, from, bytes) in drain(&mut r, last, to) {
                arrived += 1;
                prop_assert!(before <= due && due <= last);
                before = due;
                if settings.corrupt == 0.0 {
                    let k = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
                    let (at, sender, receiver, whole) = &sent[k];
                    prop_assert_eq!((*sender, *receiver, whole), (from, to, &bytes));
                    prop_assert!(due >= at + u64::from(settings.delay_ms));
                }
            }
        }
        let c = r.counts();
        prop_assert_eq!((c.sent, c.delivered), (traffic.len() as u64, arrived as u64));
        prop_assert_eq!(c.sent + c.duplicated, c.out_of_range + c.lost + c.delivered + r.in_flight());
        // Only what is held back is still on its way, one a direction at most.
        prop_assert!(r.in_flight() <= 25.min(c.held));
        if settings.reorder == 0.0 {
            prop_assert_eq!(r.in_flight(), 0);
        }
    }

    /// The order in which nodes are simulated does not matter: as long as each sends the same, each receives the same.
    #[test]
    fn the_order_of_turns_does_not_show(settings in any_settings(), seed: u64, rounds in 1u64..20) {
        let play = |order: [usize; 5]| {
            let mut r = RadioChannel::new(&settings, 5, seed).unwrap();
            (0..5).for_each(|i| r.set_position(i, (40.0 * i as f32, 0.0)));
            let mut received: [Vec<_>; 5] = Default::default();
            for round in 0..rounds {
                order.iter().for_each(|&i| r.broadcast(500 * round, i, &[i as u8, round as u8]));
                order.iter().for_each(|&i| received[i].extend(drain(&mut r, 500 * round + 200, i)));
            }
            (received, r.counts(), r.in_flight())
        };
        prop_assert_eq!(play([0, 1, 2, 3, 4]), play([3, 0, 4, 2, 1]));
    }

    /// A channel that is reset behaves as a new one.
    #[test]
    fn a_reset_leaves_nothing(settings in any_settings(), (one, other) in (any::<u64>(), any::<u64>())) {
        let mut used = RadioChannel::new(&settings, 2, one).unwrap();
        used.set_position(0, (0.0, 0.0));
        used.set_position(1, (500.0, 0.0));
        arrivals(&mut used, 50, 3);
        used.reset(other);
        let mut new = RadioChannel::new(&settings, 2, other).unwrap();
        prop_assert_eq!(arrivals_raw(&mut used), arrivals_raw(&mut new));
        prop_assert_eq!((used.counts(), used.in_flight()), (new.counts(), new.in_flight()));
    }

    /// What else the channel does never changes which datagrams it loses.
    #[test]
    fn losses_are_the_same_whatever_else_happens(settings in any_settings(), seed: u64) {
        let only = RadioSettings { loss: settings.loss, burst: settings.burst, ..RadioSettings::default() };
        let lost = |settings: &RadioSettings| {
            let mut r = RadioChannel::new(settings, 2, seed).unwrap();
            let lost_now = |r: &mut RadioChannel| { r.send(0, 0, 1, b"abc"); r.counts().lost };
            (0..60).map(|_| lost_now(&mut r)).collect::<Vec<_>>()
        };
        prop_assert_eq!(lost(&settings), lost(&only));
    }
}

fn arrivals_raw(channel: &mut RadioChannel) -> Vec<(u64, usize, Vec<u8>)> {
    (0..50u32).for_each(|k| channel.send(u64::from(k) * 3, 0, 1, &k.to_le_bytes()));
    drain(channel, u64::MAX, 1)
}
