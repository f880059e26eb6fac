//! Size of the study of the field: draws, and records of each.

use rig::DefectKind;

/// Size of the study.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Settings {
    /// Number of draws of training and validation sets.
    pub draws: u32,
    /// Number of the first draw; other numbers give other traces.
    pub first: u32,
    /// Number of healthy training records.
    pub healthy_training: u32,
    /// Number of training records of each defect, for the discriminant.
    pub defects_training: u32,
    /// Number of healthy validation records.
    pub healthy: u32,
    /// Number of validation records of each defect and size.
    pub defects: u32,
    /// Number of records that are judged together, those of one run.
    pub together: u32,
    /// Features of the detector; those of [`recipe`](super::recipe) if empty.
    pub features: Vec<String>,
    /// Whether the program chooses them, as it does for a user who names none.
    pub default: bool,
}

impl Settings {
    /// 150 healthy records for training; 300 healthy ones and 60 of each defect for validation.
    #[must_use]
    pub const fn standard(draws: u32, first: u32) -> Self {
        Self {
            draws,
            first,
            healthy_training: 150,
            defects_training: 60,
            healthy: 300,
            defects: 60,
            together: 1,
            features: vec![],
            default: false,
        }
    }

    /// Number of validation records of a kind.
    #[must_use]
    pub fn judged(&self, kind: DefectKind) -> u32 {
        if kind == DefectKind::Healthy { self.healthy } else { self.defects }
    }
}
