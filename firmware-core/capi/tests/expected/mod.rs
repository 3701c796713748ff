//! What `flight.c` must print: the same calls in Rust.

use covey_capi::{
    CoveyDecision, CoveyFeature, CoveyMap, CoveyNeighbour, CoveyNeighbourFeature, CoveyScene, CoveyVec2, CoveyView,
    Status,
};
use firmware_core::action::ACTIONS;
use firmware_core::actor::{Actor, MAX_FEATURE, Mode, NeighbourFeature, fingerprint};
use firmware_core::geometry::{State, TICKS_PER_U, Vec2};
use firmware_core::navigation::{LocalFrame, MapScale, heading_centidegrees, heading_rad};
use firmware_core::observation::{LEN, MAX_NEIGHBOURS, Neighbour, Neighbours, Scene, observe};
use std::fmt::Write as _;
use std::mem::offset_of;

const SEED: u64 = 10;
const ID: u16 = 7;
const STEP: u32 = 5;

/// Sizes and offsets that depend on how long a pointer is.
pub struct Pointers {
    size: usize,
    scene: [(&'static str, usize); 9],
    feature: [(&'static str, usize); 3],
}

macro_rules! pointers {
    ($pointer:ty, $scene:ty, $feature:ty) => {
        Pointers {
            size: size_of::<$pointer>(),
            scene: [
                ("sizeof(covey_scene)", size_of::<$scene>()),
                ("covey_scene.velocity", offset_of!($scene, velocity)),
                ("covey_scene.half_side", offset_of!($scene, half_side)),
                ("covey_scene.id", offset_of!($scene, id)),
                ("covey_scene.tie", offset_of!($scene, tie)),
                ("covey_scene.neighbours", offset_of!($scene, neighbours)),
                ("covey_scene.neighbour_count", offset_of!($scene, neighbour_count)),
                ("covey_scene.pois", offset_of!($scene, pois)),
                ("covey_scene.poi_count", offset_of!($scene, poi_count)),
            ],
            feature: [
                ("sizeof(covey_neighbour_feature)", size_of::<$feature>()),
                ("covey_neighbour_feature.degree", offset_of!($feature, degree)),
                ("covey_neighbour_feature.attended", offset_of!($feature, attention_source)),
            ],
        }
    };
}

/// On this computer.
pub const HERE: Pointers = pointers!(*const u8, CoveyScene, CoveyNeighbourFeature);
/// On Cortex-M, where addresses and sizes are numbers of four bytes.
pub const CORTEX_M: Pointers = pointers!(u32, Scene32, NeighbourFeature32);

/// [`CoveyScene`] on Cortex-M.
#[repr(C)]
struct Scene32 {
    position: CoveyVec2,
    velocity: CoveyVec2,
    half_side: i32,
    id: u16,
    tie: i8,
    neighbours: u32,
    neighbour_count: u32,
    pois: u32,
    poi_count: u32,
}

/// [`CoveyNeighbourFeature`] on Cortex-M.
#[repr(C)]
struct NeighbourFeature32 {
    values: u32,
    degree: u8,
    attention_source: i16,
}

/// What the program must print for this actor file.
pub fn output(pointers: &Pointers, file: &[u8]) -> String {
    layout(pointers) + &navigation() + &flight(file)
}

fn layout(pointers: &Pointers) -> String {
    let mut out = String::new();
    let mut line = |name: &str, value: usize| writeln!(out, "{name} {value}").unwrap();
    line("sizeof(covey_actor)", 8 * (8 + 8 * pointers.size));
    line("sizeof(covey_vec2)", size_of::<CoveyVec2>());
    line("sizeof(covey_neighbour)", size_of::<CoveyNeighbour>());
    line("covey_neighbour.velocity", offset_of!(CoveyNeighbour, velocity));
    line("covey_neighbour.id", offset_of!(CoveyNeighbour, id));
    line("covey_neighbour.tie", offset_of!(CoveyNeighbour, tie));
    pointers.scene.iter().for_each(|&(name, value)| line(name, value));
    line("sizeof(covey_view)", size_of::<CoveyView>());
    line("covey_view.degree", offset_of!(CoveyView, degree));
    line("covey_view.kept", offset_of!(CoveyView, kept));
    line("sizeof(covey_feature)", size_of::<CoveyFeature>());
    line("covey_feature.attending", offset_of!(CoveyFeature, attention_destination));
    line("covey_feature.attended", offset_of!(CoveyFeature, attention_source));
    line("covey_feature.own", offset_of!(CoveyFeature, own));
    pointers.feature.iter().for_each(|&(name, value)| line(name, value));
    line("sizeof(covey_decision)", size_of::<CoveyDecision>());
    line("covey_decision.action", offset_of!(CoveyDecision, action));
    line("sizeof(covey_map)", size_of::<CoveyMap>());
    line("covey_map.unit_m", offset_of!(CoveyMap, unit_m));
    line("covey_map.step_ms", offset_of!(CoveyMap, step_ms));
    line("COVEY_OBSERVATION", LEN);
    line("COVEY_FEATURE", MAX_FEATURE);
    line("COVEY_NEIGHBOURS", MAX_NEIGHBOURS);
    line("COVEY_ACTIONS", ACTIONS);
    line("COVEY_TICKS_PER_U", TICKS_PER_U as usize);
    for (status, _) in Status::ALL {
        // OutOfRange is COVEY_OUT_OF_RANGE.
        let name: String = format!("{status:?}")
            .chars()
            .flat_map(|c| if c.is_uppercase() { vec!['_', c] } else { vec![c.to_ascii_uppercase()] })
            .collect();
        line(&format!("COVEY{name}"), status as usize);
    }
    line("COVEY_SAMPLE", 0);
    line("COVEY_ARGMAX", 1);
    out
}

fn numbers<T: std::fmt::Display>(items: impl IntoIterator<Item = T>) -> String {
    items.into_iter().map(|i| format!(" {i}")).collect()
}

/// After the layout.
fn navigation() -> String {
    let (lat, lon) = (473_977_418, 85_455_939);
    let (frame, scale) = (LocalFrame::new(lat, lon).unwrap(), MapScale { unit_m: 2.5, step_ms: 2000 });
    let mut out = String::new();
    let mut line = |text: String| out += &(text + "\n");
    for i in 0..5 {
        let position = scale.position(frame.local(lat + 9001 * i, lon - 12_345 * i).unwrap());
        line("covey_map_position(&map, map.lat_e7 + 9001 * i, map.lon_e7 - 12345 * i, &position) 0".into());
        line(format!("position {} {}", position.x, position.y));
        let (lat, lon) = frame.geodetic_e7(scale.place(position));
        line("covey_map_degrees(&map, position, &lat, &lon) 0".into());
        line(format!("degrees {lat} {lon}"));
        let velocity = scale.velocity(f64::from(1.25 * i as f32), (-0.7f32).into());
        line("covey_map_velocity(&map, 1.25f * (float)i, -0.7f, &velocity) 0".into());
        line(format!("velocity {} {}", velocity.x, velocity.y));
        let (east, north) = ((i - 2) as f32, 0.75);
        let (radians, hundredths) = (heading_rad(east, north).unwrap(), heading_centidegrees(east, north).unwrap());
        line(format!("heading {:08x} {hundredths}", radians.to_bits()));
    }
    line("covey_heading_cdeg(0, 0) -1".into());
    line("covey_heading_rad(0, 0) -1".into());
    line("covey_map_position(&map, 0, 0, &position) 36".into());
    line("covey_map_position(NULL, 0, 0, &position) 32".into());
    line("covey_map_degrees(&map, position, &lat, NULL) 32".into());
    line("covey_map_degrees(&map, position, &lat, &lon) 36".into());
    line("covey_map_velocity(&map, 1, 1, &velocity) 36".into());
    out
}

/// After that.
fn flight(file: &[u8]) -> String {
    let actor = Actor::load(file).unwrap();
    let mut out = String::new();
    let mut line = |text: String| out += &(text + "\n");
    line("covey_self_test(&actor) 33".into());
    line("covey_content_hash(&actor) == 0 1".into());
    line("covey_load(&actor, file, length - 1) 1".into());
    line("covey_encode(&actor, view.observation, &own) 33".into());
    line("covey_load(&actor, file, length) 0".into());
    line("covey_encode(&actor, view.observation, &own) 34".into());
    line("covey_decide(&actor, &own, 1, NULL, 0, COVEY_SAMPLE, 1, 2, 3, &decision) 34".into());
    line("covey_self_test(&actor) 0".into());
    line("covey_load(NULL, file, length) 32".into());
    line("covey_encode(&actor, NULL, &own) 32".into());
    line(format!("content hash {:016x}", actor.content_hash()));
    line(format!("message hash {:08x}", actor.message_hash()));
    line(format!("signature {:016x}", fingerprint(&actor, 100)));
    line(format!("covey_feature_width(&actor) {}", actor.dimensions().feature));
    let tie = actor.tie_breaker(SEED, ID, STEP);
    line(format!("covey_tie_breaker(&actor, 10, 7, 5) {tie}"));

    let own = State { position: Vec2 { x: 102_400, y: 102_400 }, velocity: Vec2 { x: 2048, y: -1024 } };
    let mut neighbours = Neighbours::new();
    for i in (0..20).filter(|&i| i != 4) {
        let (offset, velocity) = (Vec2 { x: 900 * i, y: -300 * i }, Vec2 { x: 10 * i, y: -20 * i });
        neighbours.insert(Neighbour { id: 100 + i as u16, offset, velocity, tie: (3 * i - 30) as i8 });
    }
    let pois = (0..30).map(|i| Vec2 { x: 102_400 - 700 * i, y: 102_400 + 100 * i });
    let observation = observe(&Scene { id: ID, own, tie, half_side: 102_400, neighbours: &neighbours }, pois);
    let count = neighbours.as_slice().len();
    let degree = count as u8 + 1;
    let kept = neighbours.as_slice().iter().map(|n| n.id).chain(std::iter::repeat(0)).take(MAX_NEIGHBOURS);
    line("covey_observe(&scene, &view) 0".into());
    line(format!("observation{}", numbers(observation)));
    line(format!("degree {degree} kept{}", numbers(kept)));
    line("covey_encode(&actor, view.observation, &own) 0".into());
    let h = actor.encode(&observation);
    line(format!("feature{} {} {}", numbers(h.values), h.attention_destination, h.attention_source));
    line(format!("own{}", numbers(h.own)));

    let width = usize::from(actor.dimensions().feature);
    let values: Vec<Vec<i8>> =
        (0..count).map(|i| (0..width).map(|k| ((7 * i + 5 * k) % 128) as i8).collect()).collect();
    let features = values.iter().zip(0..).map(|(values, i)| NeighbourFeature {
        values,
        degree: 1 + i as u8,
        attention_source: 40 * i - 300,
    });
    let logits = actor.logits(&h, degree, features);
    for mode in [Mode::Sample, Mode::Argmax] {
        line("covey_decide(&actor, &own, view.degree, features, (size_t)count, mode, 10, 7, 5, &decision) 0".into());
        let action = actor.choose(&logits, mode, SEED, ID, STEP).index();
        line(format!("action {action} logits{}", numbers(logits)));
    }
    let decide =
        |arguments: &str, status: i32| format!("covey_decide(&actor, &own, {arguments}, 10, 7, 5, &decision) {status}");
    line(decide("1, NULL, 0, COVEY_ARGMAX", 0));
    let alone = actor.choose(&actor.logits(&h, 1, []), Mode::Argmax, SEED, ID, STEP).index();
    line(format!("alone {alone}"));
    line(decide("0, NULL, 0, COVEY_ARGMAX", 36));
    line(decide("18, NULL, 0, COVEY_ARGMAX", 36));
    line(decide("1, NULL, 0, 2", 36));
    line(decide("1, NULL, 1, COVEY_ARGMAX", 32));
    line(decide("1, features, 17, COVEY_ARGMAX", 36));
    line(decide("1, features, 1, COVEY_ARGMAX", 36));
    line(decide("2, features, 1, COVEY_ARGMAX", 36));
    line(decide("2, features, 1, COVEY_ARGMAX", 32));
    line("covey_observe(&scene, &view) 32".into());
    line("covey_observe(NULL, &view) 32".into());
    line("the actor gives other logits than when it was exported: do not fly; unknown status".into());
    out
}
