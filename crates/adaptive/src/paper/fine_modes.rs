//! Bodies whose fine models have low-frequency modes of their own during an impact, as in \[A\] 4.4
//! (theory section A.6).
//!
//! The fine model then gives all of the body: inertia, couplings, markers, observed points.
//! Coordinates change with the modes, their number does not, so that states keep their places. What
//! is built on the coarse mesh sees the body's modes through the map back to coarse coordinates.

use ffr_dynamics::body::StandardInputData;
use ffr_dynamics::reduction::blocks::dense;
use ffr_dynamics::reduction::modal::ReducedBasis;
use nalgebra::UnitQuaternion;

use crate::body::field::Field;
use crate::body::field_body::FieldBody;
use crate::body::fine::refined::FineBody;
use crate::body::reduced::ReducedBody;
use crate::body::reduced::damping::damping;
use crate::body::splines::ElasticBody;
use crate::error::AdaptiveError;
use crate::paper::transfer::StateTransfer;
use crate::spec::FrameSpec;
use crate::spec::TransferMethod;

/// Modes of a fine model, on it and on the coarse one.
pub struct FineModes {
    /// The modes on the fine mesh, and the data that follow from them.
    pub reduced: ReducedBody,
    /// The modes on the coarse mesh, as well as it can show them: coarse modes times the map to
    /// coarse coordinates.
    pub view: ReducedBody,
    /// The maps of the state.
    pub transfer: StateTransfer,
}

/// Refuses bodies whose coordinates a fine model with modes of its own cannot have.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] with a remedy.
pub fn check_fine_modes(body: &dyn FieldBody, reduced: &ReducedBody) -> Result<(), AdaptiveError> {
    let refuse = |what| Err(AdaptiveError::unsupported_body(body.name(), what));
    if reduced.basis.n_modes() != reduced.basis.n_low {
        return refuse("it has modes of an interface, fine models with modes = \"own\" have free modes alone; choose modes = \"prolonged\" \
         for its contacts".into());
    }
    if body.settings().geometric_stiffening {
        return refuse("fine models with modes = \"own\" have no geometric stiffening; choose modes = \"prolonged\" for its contacts".into());
    }
    Ok(())
}

impl FineModes {
    /// The model of `coarse` refined as `fine`, whose modes `basis` get the signs of the coarse
    /// ones.
    ///
    /// # Errors
    /// [`AdaptiveError::Reduction`] with the body's name; [`AdaptiveError::Unsupported`], see [`check_fine_modes`].
    pub fn new(
        coarse: (&ElasticBody, &ReducedBody),
        fine: &FineBody,
        mut basis: ReducedBasis,
        method: TransferMethod,
    ) -> Result<Self, AdaptiveError> {
        let (body, reduced) = coarse;
        check_fine_modes(body, reduced)?;
        let fail = |source| AdaptiveError::Reduction { body: body.name.clone(), source };
        align(fine, &fine.prolong(&body.assembled, reduced.basis.shapes.as_ref()), &mut basis);
        let transfer = StateTransfer::new(method, (body, &reduced.basis), (fine, &basis))?;
        let stiffness: Vec<f64> = basis.omega.iter().map(|w| w * w).collect();
        let mut data =
            StandardInputData::new(&fine.assembled, basis.shapes.as_ref(), &stiffness).map_err(fail)?;
        data.modal_damping =
            damping(&body.spec.flexible.damping, &stiffness, basis.first_static()).map_err(fail)?;
        let mut framed = None;
        if let FrameSpec::Tangent(place) = &body.spec.flexible.frame {
            let support = fine.marker_weights(place, UnitQuaternion::identity())?;
            let marker = support.marker("frame", basis.shapes.as_ref()).map_err(fail)?;
            let frame = marker.tangent_frame(body.assembled.motion);
            framed = Some(frame.shifted_shapes(&fine.assembled, basis.shapes.as_ref()).map_err(fail)?);
            data = data.in_tangent_frame(&frame).map_err(fail)?;
        }
        let back = transfer.to_coarse.as_ref();
        let view = ReducedBody {
            basis: ReducedBasis {
                shapes: dense::product(reduced.basis.shapes.as_ref(), back),
                omega: basis.omega.clone(),
                n_low: basis.n_low,
                rigid: reduced.basis.rigid.clone(),
                multiplet: None,
                static_loads: reduced.basis.static_loads.clone(),
            },
            framed: reduced.framed.as_ref().map(|shapes| dense::product(shapes.as_ref(), back)),
            residual: None,
            data: data.clone(),
            loads: reduced.loads.clone(),
        };
        let reduced = ReducedBody { basis, framed, residual: None, data, loads: reduced.loads.clone() };
        Ok(Self { reduced, view, transfer })
    }
}

/// Gives each mode of `basis` the sign of the prolonged coarse one of the same number, so that
/// coordinates go on smoothly.
fn align(fine: &FineBody, prolonged: &faer::Mat<f64>, basis: &mut ReducedBasis) {
    let momenta = fine.assembled.mass_product(prolonged.as_ref());
    for j in 0..basis.n_modes().min(prolonged.ncols()) {
        let along: f64 = (0..momenta.nrows()).map(|i| momenta[(i, j)] * basis.shapes[(i, j)]).sum();
        if along < 0.0 {
            basis.shapes.as_mut().col_mut(j).iter_mut().for_each(|u| *u = -*u);
        }
    }
}
