//! The shaft's constants: their ranges, and their bytes in the binary model.

use super::binary::{Reader, Writer, flag, read_guard, write_guard};
use super::{ModelError, all_within, check, is_power_of_two};
use crate::estimate::{
    Balance, Guard, MAX_CURRENT_DELAY, MAX_HARMONICS, ShaftModel, StateVariable, TrackedOrder, Tracking,
};

/// Orders beyond this would turn more than half a turn between samples at any speed worth tracking.
const MAX_ORDER_Q16: i32 = 1000 << 16;

/// Checks every number against its range.
pub(super) fn validate<const K: usize>(shaft: &ShaftModel<K>) -> Result<(), ModelError> {
    let ShaftModel { guard, current_delay, balance, tracking } = shaft;
    let Guard { limit, saturation, stuck_samples, .. } = guard;
    check(all_within(limit, f32::MIN_POSITIVE, 1e12), "shaft's signal limit")?;
    let ordered = saturation.iter().zip(limit).all(|(most, limit)| *most > 0.0 && most <= limit);
    check(ordered && stuck_samples.iter().all(|count| *count != 1), "shaft's saturation or stuck samples")?;
    check((0.0..=MAX_CURRENT_DELAY).contains(current_delay), "current delay")?;

    let StateVariable { gain, damping, rate_per_s } = balance.filter;
    check(balance.interval_s > 0.0 && balance.interval_s.is_finite(), "shaft's sampling interval")?;
    let expected = StateVariable::new(gain, balance.interval_s);
    let own = damping.to_bits() == expected.damping.to_bits() && rate_per_s.to_bits() == expected.rate_per_s.to_bits();
    check((1e-4..=10.0).contains(&gain) && own, "torque balance's filter")?;
    check(balance.row_interval > 0, "torque balance's row interval")?;
    let velocities = [balance.sign_velocity_rad_s, balance.usual_velocity_rad_s];
    check(all_within(&velocities, 1e-6, 1e6), "velocity of the Coulomb sign or the drag")?;
    // Beyond that, sums of squares over a segment could leave the range of f32.
    let [current, velocity, load] = *limit;
    let largest = [velocity * rate_per_s, velocity, load, current];
    let bounded = |(scale, limit): (&f32, f32)| is_power_of_two(*scale) && *scale <= 1e14 / limit;
    check(balance.scale.iter().zip(largest).all(bounded), "torque balance's scale")?;
    check(all_within(&balance.nominal, -1e12, 1e12), "nominal torque balance")?;

    if tracking.count as usize > K {
        return Err(ModelError::Capacity("bearing orders"));
    }
    check((1..=MAX_HARMONICS).contains(&(tracking.harmonics as usize)), "number of harmonics")?;
    for (k, order) in tracking.orders.iter().enumerate() {
        let in_use = k < tracking.count as usize;
        check(is_good(order, in_use, tracking.harmonics as usize), "bearing order or its weights")?;
    }
    check(tracking.block_samples > 1, "block of the order tracking")
}

/// Not inlined, where it would be unrolled for every order: flash is dear.
#[inline(never)]
fn is_good(order: &TrackedOrder, in_use: bool, harmonics: usize) -> bool {
    if !in_use {
        return *order == TrackedOrder::NONE;
    }
    let (computed, rest) = order.weights.split_at_checked(harmonics).unwrap_or((&order.weights, &[]));
    (1..=MAX_ORDER_Q16).contains(&order.order_q16)
        && all_within(computed, 0.0, 1e3)
        && computed.iter().any(|w| *w > 1e-3)
        && rest.iter().all(|w| w.to_bits() == 0)
}

pub(super) fn read<const K: usize>(reader: &mut Reader<'_>) -> Result<ShaftModel<K>, ModelError> {
    let guard = read_guard(reader)?;
    let current_delay = reader.f32()?;
    let interval_s = reader.f32()?;
    let filter = StateVariable { gain: reader.f32()?, damping: reader.f32()?, rate_per_s: reader.f32()? };
    let (row_interval, settle) = (reader.u8()?, reader.u16()?);
    let (sign_velocity_rad_s, usual_velocity_rad_s) = (reader.f32()?, reader.f32()?);
    let load = flag(reader.u8()?, "load flag")?;
    let (mut scale, mut nominal) = ([0.0; 4], [0.0; 5]);
    reader.fill(&mut scale, 4)?;
    reader.fill(&mut nominal, 5)?;
    let balance = Balance {
        interval_s,
        filter,
        row_interval,
        settle,
        sign_velocity_rad_s,
        usual_velocity_rad_s,
        load,
        scale,
        nominal,
    };
    let count = reader.size(K, "bearing orders")?;
    let harmonics = reader.u8()?;
    let (still, block_samples) = (reader.u32()?, reader.u16()?);
    let mut tracking = Tracking { orders: [TrackedOrder::NONE; K], count, harmonics, still, block_samples };
    for order in tracking.orders.iter_mut().take(count as usize) {
        order.order_q16 = reader.u32()?.cast_signed();
        reader.fill(&mut order.weights, MAX_HARMONICS)?;
    }
    Ok(ShaftModel { guard, current_delay, balance, tracking })
}

pub(super) fn write<const K: usize>(writer: &mut Writer<'_>, shaft: &ShaftModel<K>) -> Result<(), ModelError> {
    let ShaftModel { guard, current_delay, balance, tracking } = shaft;
    let StateVariable { gain, damping, rate_per_s } = &balance.filter;
    write_guard(writer, guard)?;
    writer.floats([current_delay, &balance.interval_s, gain, damping, rate_per_s])?;
    writer.bytes(&[balance.row_interval])?;
    writer.bytes(&balance.settle.to_le_bytes())?;
    writer.floats([&balance.sign_velocity_rad_s, &balance.usual_velocity_rad_s])?;
    writer.bytes(&[u8::from(balance.load)])?;
    writer.floats(balance.scale.iter().chain(&balance.nominal))?;
    writer.bytes(&[tracking.count, tracking.harmonics])?;
    writer.bytes(&tracking.still.to_le_bytes())?;
    writer.bytes(&tracking.block_samples.to_le_bytes())?;
    for order in tracking.orders.iter().take(tracking.count as usize) {
        writer.bytes(&order.order_q16.to_le_bytes())?;
        writer.floats(&order.weights)?;
    }
    Ok(())
}
