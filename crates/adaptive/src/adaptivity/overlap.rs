//! How much of the approach of two bodies may be penetration, and what it is judged beside
//! (docs/theory.md section A.9).

/// The largest share of the approach of two bodies that may be penetration and not deformation
/// (theory Eq. A.36). The approach at which a force is reached, and with it the stiffness of the
/// contact, is off by no more than this share; of a body between two flat faces by twice as much.
pub const MOST_OVERLAP: f64 = 0.03;

/// The largest share of penetration in the approach between flat faces while waves say how large
/// the force is. The impact then lasts longer by half of this share; springs that are three times
/// as stiff ring by a quarter of the force and more.
pub const MOST_OVERLAP_OF_WAVES: f64 = 0.1;

/// Change of a peak force per share of penetration at most: that of springs in series with a linear contact. Of spheres it is less than half
/// as much, of cones none (theory Eq. A.44).
const PEAK_PER_SHARE: f64 = 0.5;

/// Round trips of waves after which the stress along a body is even and it yields like a spring:
/// the criterion of Davies and Hunter (1963) for specimens in the split Hopkinson bar.
pub const TRIPS: f64 = std::f64::consts::PI;

/// What yields beside the penalty springs while two bodies approach each other (theory
/// section A.9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pressing {
    /// Waves between flat faces, which say how large the force is and how long it lasts:
    /// [`MOST_OVERLAP_OF_WAVES`] of the approach, and what is missing is added, for stiffer springs
    /// than the modes follow ring.
    Waves,
    /// A body as a whole, through which waves have run to and fro [`TRIPS`] times: its stiffness
    /// says how fast the force rises. Also what yields at a smooth touch or an edge.
    /// [`MOST_OVERLAP`], and ten times the factor.
    Body,
}

impl Pressing {
    /// How bodies are pressed by flat faces `time` \[s\] after these have met, if a wave takes
    /// `round_trip` \[s\] to and fro through the one of them that is crossed sooner.
    pub fn of_flat_faces(time: f64, round_trip: f64) -> Self {
        if time > TRIPS * round_trip { Self::Body } else { Self::Waves }
    }

    /// Share of the approach that may be penetration.
    fn most_overlap(self) -> f64 {
        match self {
            Self::Waves => MOST_OVERLAP_OF_WAVES,
            Self::Body => MOST_OVERLAP,
        }
    }
}

/// How much of the approach of two bodies was penetration and not deformation, at the instant of
/// the largest approach.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Penetration over approach.
    pub share: f64,
    /// What yielded meanwhile.
    pub pressing: Pressing,
}

impl Overlap {
    /// Share that is allowed.
    pub fn most(&self) -> f64 {
        self.pressing.most_overlap()
    }

    /// Bound of the relative change of the peak force that springs without limit would bring (theory Eq. A.44); none between flat
    /// faces, whose force their springs ring with.
    pub fn peak_change(&self) -> Option<f64> {
        (self.pressing == Pressing::Body).then_some(PEAK_PER_SHARE * self.share)
    }

    /// Whether the springs were too soft.
    pub fn is_too_much(&self) -> bool {
        self.share > self.most()
    }
}
