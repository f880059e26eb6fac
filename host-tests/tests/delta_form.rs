use host_tests::oracle::{self, Record};
use host_tests::plants::*;
#[test]
fn conds() {
    for plant in &PLANTS {
        for db in [25.0, 60.0] {
        let samples: Vec<_> = plant.source(plant.noise(db), 3).take(20000).collect();
        let order = plant.order();
        let [raw, delta] = oracle::conditions(&Record::new(&samples), order, order.depth()..20000);
        println!("{:20} {:?} {db} cond {raw:.1e} {delta:.1e}", plant.name, order.to_array());
    }}
}
