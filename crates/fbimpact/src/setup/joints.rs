//! Joints and loads with attachments in the axes of the bodies.

use adaptive::spec::time_curve::CubicSpline;
use adaptive::spec::{Attachment, CoordinateSpec, JointSpec, LoadSpec, Place as PlaceSpec, TimeCurve};
use nalgebra::UnitQuaternion;

use super::bodies::{Bodies, rotation};
use crate::error::AppError;
use crate::scenario::{self, Curve, Place};

/// A joint; `axes` of both attachments coincide when the bodies have the orientation that the scenario gives.
///
/// # Errors
/// [`AppError::Model`] for a place that does not exist.
pub fn joint(joint: &scenario::Joint, bodies: &Bodies) -> Result<JointSpec, AppError> {
    let subject = format!("joints.{}", joint.name);
    let axes = rotation(joint.axes);
    let coordinates = joint.coordinates.iter().map(|c| coordinate(c, &subject));
    Ok(JointSpec {
        name: joint.name.clone(),
        kind: joint.kind,
        parent: attachment(&joint.parent, Some(axes), bodies, &subject)?,
        child: attachment(&joint.child, Some(axes), bodies, &subject)?,
        positions: joint.positions.clone(),
        velocities: joint.velocities.clone(),
        coordinates: coordinates.collect::<Result<_, AppError>>()?,
    })
}

/// A load.
///
/// # Errors
/// [`AppError::Model`] for a place that does not exist.
pub fn load(load: &scenario::Load, bodies: &Bodies) -> Result<LoadSpec, AppError> {
    let subject = format!("loads.{}", load.name);
    let mut components: [Option<TimeCurve>; 6] = Default::default();
    for (slot, given) in components.iter_mut().zip(&load.components) {
        *slot = curve(given.as_ref(), &subject)?;
    }
    Ok(LoadSpec {
        name: load.name.clone(),
        // Axes that turn with the attachment are those of the body.
        at: attachment(&load.at, None, bodies, &subject)?,
        components,
        is_following: load.is_following,
    })
}

/// An attachment with `axes` given in space for the orientation of the scenario; `None`: the axes of the body.
fn attachment(
    at: &scenario::Attachment,
    axes: Option<UnitQuaternion<f64>>,
    bodies: &Bodies,
    subject: &str,
) -> Result<Attachment, AppError> {
    let Some(index) = at.body else {
        let Place::Point(point) = at.at else {
            return Err(AppError::Model(format!("{subject}: ground has no markers, give a point")));
        };
        let rotation = axes.unwrap_or_else(UnitQuaternion::identity);
        return Ok(Attachment { body: None, place: PlaceSpec::Point(point), rotation });
    };
    let body = bodies.moving(index, subject)?;
    let rotation = axes.map_or_else(UnitQuaternion::identity, |axes| bodies.rotation(body).inverse() * axes);
    Ok(Attachment { body: Some(body), place: bodies.held(body, &at.at)?, rotation })
}

fn coordinate(given: &scenario::JointCoordinate, subject: &str) -> Result<CoordinateSpec, AppError> {
    Ok(CoordinateSpec {
        stiffness: given.stiffness,
        rest: given.rest,
        damping: given.damping,
        drive: curve(given.drive.as_ref(), subject)?,
        motion: curve(given.motion.as_ref(), subject)?,
    })
}

fn curve(curve: Option<&Curve>, subject: &str) -> Result<Option<TimeCurve>, AppError> {
    Ok(match curve {
        None => None,
        Some(Curve::Polynomial { coefficients }) => {
            Some(TimeCurve::Polynomial { coefficients: coefficients.clone() })
        }
        Some(&Curve::Harmonic { amplitude, frequency, phase, offset }) => {
            Some(TimeCurve::Harmonic { amplitude, frequency, phase, offset })
        }
        Some(&Curve::SpinUp { rate, duration }) => Some(TimeCurve::SpinUp { rate, duration }),
        Some(Curve::Table { times, values }) => {
            let spline = CubicSpline::new(times.clone(), values.clone());
            let unsound = || AppError::Model(format!("{subject}: no spline goes through the table"));
            Some(TimeCurve::Table(spline.ok_or_else(unsound)?))
        }
    })
}
