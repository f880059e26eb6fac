//! RAM of front end and detector, as lines of JSON: three currents and two further channels by 8, least squares of
//! eight parameters, and a shaft with one to four orders.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[macro_use]
mod support;

use bearing_watch::Detector;
use bearing_watch::drive::FrontEnd;
use bearing_watch::plan::Structure;
use bearing_watch::plan::{Layout, Load, Memory, Method, RegressionLayout, ShaftLayout};

main!(run);

/// Bytes of both.
macro_rules! bytes {
    ($orders:literal) => {{
        bearing_watch::plan! {
            /// A drive.
            pub struct Own;
            /// One sample of it.
            pub struct OwnSample with angle {
                current_a: "A", velocity_ref_rad_s: "rad/s", load_nm: "N·m", velocity_rad_s: "rad/s",
            }
            layout: Layout {
                regression: Some(RegressionLayout {
                    structure: Structure::new(2, 3, 3, 1, 1),
                    method: Method::LeastSquares,
                    memory: Memory::Segment,
                    y: current_a,
                    u1: velocity_ref_rad_s,
                    u2: load_nm,
                }),
                shaft: Some(ShaftLayout {
                    current: current_a,
                    velocity: Some(velocity_rad_s),
                    load: Load::Measured(load_nm),
                    orders: $orders,
                    harmonics: 3,
                    decimation: 1,
                }),
                features: 9,
                coordinates: 3,
                rising: 1,
                classes: 3,
                ..Layout::EMPTY
            }
        }
        let bytes = size_of::<FrontEnd<2, 8>>() + size_of::<Detector<'static, Own>>();
        let orders = $orders;
        say!(r#"{{"name":"front end and detector, RAM","n":{orders},"instructions":null,"bytes":{bytes}}}"#);
    }};
}

fn run() {
    bytes!(1);
    bytes!(2);
    bytes!(3);
    bytes!(4);
}
